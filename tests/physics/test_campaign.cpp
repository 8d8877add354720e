#include <gtest/gtest.h>

#include <iostream>

#include "support/campaign.hpp"

/// A slice of the campaign of extremes; the program `campaign` in bench/ runs the whole of it.
namespace {

campaign::Report slice(std::vector<std::string> families, int steps) {
  campaign::Options options;
  options.steps = steps;
  options.families = std::move(families);
  return campaign::run(options);
}

TEST(Campaign, EqualSeedsGiveEqualScenesAndEqualRuns) {
  const campaign::Report a = slice({"mass_ratio", "wedging"}, 2000), b = slice({"mass_ratio", "wedging"}, 2000);
  EXPECT_EQ(a.total().iterations, b.total().iterations);
  EXPECT_EQ(a.total().distance, b.total().distance);
  EXPECT_EQ(a.total().certificate, b.total().certificate);
}

TEST(Campaign, NoStepOfTheExtremesFailsAndTheCertificateAgrees) {
  std::vector<std::string> names;
  for (const auto& family : campaign::families())
    if (family.name != "snapping") names.push_back(family.name);
  const campaign::Report report = slice(names, 16'000);
  std::cout << report;
  EXPECT_TRUE(report.failures.empty());
  EXPECT_TRUE(report.refutations.empty());
  EXPECT_GE(report.total().distance, -1e-9);
  EXPECT_LE(report.total().joint_error, 1e-9);
}

/// These steps need not have a solution. What must not happen is a step that claims one and has none.
TEST(Campaign, ALightChainThatSnapsTautIsSolvedOrReportedButNeverSilentlyWrong) {
  const campaign::Report report = slice({"snapping"}, 4000);
  std::cout << report;
  EXPECT_TRUE(report.refutations.empty());
  EXPECT_LE(report.total().joint_error, 1e-9);
  for (const auto& failure : report.failures) EXPECT_NE(failure.status, "solved");
}

}  // namespace
