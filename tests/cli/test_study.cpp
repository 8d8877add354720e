#include <algorithm>
#include <cmath>
#include <csignal>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program.hpp"
#include "study/fit.hpp"
#include "study/measure.hpp"
#include "study/plot.hpp"
#include "study/table.hpp"

namespace test_study {

// What the studies are made of, and a study as a shell sees it.

namespace fs = std::filesystem;
using cli::study::crossing;
using cli::study::fit_line;
using cli::study::fit_power_law;
using cli::study::number;

TEST(StudyFit, AnExactPowerLawIsFoundWithAnIntervalOfNoWidth) {
  const std::vector<double> x{2, 5, 10, 100},
      y{3 * std::pow(2, 1.5), 3 * std::pow(5, 1.5), 3 * std::pow(10, 1.5), 3000};
  const auto law = fit_power_law(x, y);
  EXPECT_NEAR(law.exponent, 1.5, 1e-12);
  EXPECT_NEAR(law.factor, 3, 1e-11);
  EXPECT_NEAR(law.high - law.low, 0, 1e-12);
  EXPECT_NEAR(law.at(20), 3 * std::pow(20, 1.5), 1e-9);
}

TEST(StudyFit, TheIntervalIsStudentsForTheScatterOfThePoints) {
  // ln x = 0, 1, 2 and ln y = 0, 1 + d, 2: slope 1, squared deviations 2/3 d^2, one degree of freedom.
  const double d = 0.1, e = std::exp(1.0);
  const auto law = fit_power_law(std::vector{1.0, e, e * e}, std::vector{1.0, e * std::exp(d), e * e});
  EXPECT_NEAR(law.exponent, 1, 1e-12);
  EXPECT_NEAR(law.high - 1, 12.706 * std::sqrt(2.0 / 3 * d * d / 2), 1e-9);
  EXPECT_NEAR(1 - law.low, law.high - 1, 1e-12);
}

TEST(StudyFit, TwoPointsHaveASlopeButNoInterval) {
  const auto law = fit_power_law(std::vector{1.0, 10.0}, std::vector{1.0, 100.0});
  EXPECT_NEAR(law.exponent, 2, 1e-12);
  EXPECT_TRUE(std::isinf(law.high));
}

TEST(StudyFit, ALineWithAFixedPartIsFound) {
  const auto line = fit_line(std::vector{1.0, 10.0, 100.0}, std::vector{5.0, 32.0, 302.0});
  EXPECT_NEAR(line.fixed, 2, 1e-10);
  EXPECT_NEAR(line.rate, 3, 1e-10);
  EXPECT_NEAR(line.deviation, 0, 1e-12);
}

TEST(StudyFit, ACrossingLiesOnTheLineOfTheLogarithmsAndNowhereBeyondThePoints) {
  const std::vector<double> x{1, 100}, y{1e-2, 1e-6};
  EXPECT_NEAR(crossing(x, y, 1e-4), 10, 1e-12);
  EXPECT_TRUE(std::isnan(crossing(x, y, 1e-7)));
}

TEST(StudyFit, GrowthIsToldAsMoreOrLessThanLinear) {
  const auto words = [](double low, double exponent, double high) {
    return cli::study::growth_in_words({.exponent = exponent, .low = low, .high = high}, "contacts");
  };
  EXPECT_EQ(words(0.6, 0.7, 0.8), "less than linear in the contacts");
  EXPECT_EQ(words(0.95, 1, 1.05), "linear in the contacts");
  EXPECT_EQ(words(1, 1.08, 1.16), "nearly linear in the contacts");
  EXPECT_EQ(words(1.2, 1.3, 1.4), "more than linear in the contacts");
  EXPECT_EQ(words(NAN, NAN, NAN), "too few sizes were solved to say how it grows");
}

TEST(StudyTable, TheFirstColumnIsLeftTheOthersRightAndNoLineEndsInBlanks) {
  cli::study::Table table({"scene", "us", "failed"});
  table.add({"disc", "12.5", "0"});
  table.add({"long name", "7", ""});
  EXPECT_EQ(table.text(),
            "scene        us  failed\n"
            "disc       12.5       0\n"
            "long name     7\n");
}

TEST(StudyTable, NumbersKeepTheirDigitsAndAvoidExponentsWherePeopleReadThem) {
  EXPECT_EQ(number(0), "0");
  EXPECT_EQ(number(12.345), "12.3");
  EXPECT_EQ(number(1234.5), "1234");
  EXPECT_EQ(number(0.012345), "0.0123");
  EXPECT_EQ(number(1.2345e-7), "1.23e-07");
  EXPECT_EQ(number(1.2345e7, 2), "1.2e+07");
  EXPECT_EQ(number(-4.5), "-4.5");
  EXPECT_EQ(number(std::numeric_limits<double>::quiet_NaN()), "-");
}

TEST(StudyMeasure, TheMedianOfAnEvenNumberLiesBetweenTheMiddleTwo) {
  const auto spread = cli::study::spread({4, 1, 3, 2});
  EXPECT_EQ(spread.best, 1);
  EXPECT_EQ(spread.median, 2.5);
  EXPECT_EQ(spread.worst, 4);
}

TEST(StudyPlot, TextIsQuotedAndPointsThatHaveNoLogarithmAreLeftOut) {
  const cli::study::Picture picture{.file = "a.svg",
                                    .title = "a \"b\" \\ c\nd",
                                    .x_label = "x [s]",
                                    .y_label = "y [m]",
                                    .note = "",
                                    .series = {{.label = "half_kick", .x = {1, 2, 3}, .y = {0.5, 0, std::nan("")}}}};
  const std::string script = cli::study::gnuplot_script(picture, "/tmp/a.svg");
  EXPECT_NE(script.find(R"(set title "a \"b\" \\ c\nd" noenhanced)"), std::string::npos) << script;
  EXPECT_NE(script.find("<< EOD\n1 0.5\nEOD\n"), std::string::npos) << script;
}

class StudyProgram : public Program {
 protected:
  /// Exit code; what it prints goes to out_ and err_.
  int run(const std::string& arguments, const std::string& before = "") {
    const Outcome outcome = Program::run("study " + arguments, before);
    out_ = outcome.out;
    err_ = outcome.err;
    return outcome.code;
  }

  std::string out_, err_;
};

TEST_F(StudyProgram, AnUnknownStudyIsRefusedWithTheKnownOnesAndNothingIsWritten) {
  EXPECT_EQ(run("scaling speed --out there"), 2);
  EXPECT_EQ(err_, "graphsolve: there is no study 'speed'; there are: scaling, precision\n");
  EXPECT_EQ(out_, "");
  EXPECT_FALSE(fs::exists(folder_ / "there"));
}

TEST_F(StudyProgram, AFolderThatCannotBeMadeIsRefusedBeforeAnythingIsMeasured) {
  std::ofstream(folder_ / "file") << "";
  EXPECT_EQ(run("scaling --quick --out file/there"), 2);
  EXPECT_EQ(out_, "");
  EXPECT_NE(err_.find("file/there"), std::string::npos);
}

TEST_F(StudyProgram, ScalingFindsNoFailedStepAndOneMoreLinkAlwaysCostsTheSameOperations) {
  // Without gnuplot on the path there is one sentence, and everything else.
  ASSERT_EQ(run("scaling --quick --out out", "PATH=/nowhere"), 0) << err_;
  const std::string error = err_;
  EXPECT_EQ(std::count(error.begin(), error.end(), '\n'), 1) << error;
  const auto data = nlohmann::json::parse(text("out/scaling.json"));
  EXPECT_TRUE(data["quick"]);
  for (const char* key : {"commit", "date", "processor", "compiler", "flags", "unit_ns"})
    EXPECT_TRUE(data["machine"].contains(key)) << key;
  EXPECT_NE(out_.find("which is not measured here: ConstrainedDynamics.jl 0.9.1"), out_.npos) << out_;
  for (const char* family : {"disc", "snake"}) {
    EXPECT_NE(data[family]["authors_code"]["source"].get<std::string>().find("numbers.md"), std::string::npos);
    const auto& difference = data[family]["operation_difference"];
    EXPECT_EQ(difference["smallest"], difference["largest"]) << family;
    for (const auto& row : data[family]["rows"]) {
      EXPECT_EQ(row["failed_steps"], 0) << row;
      EXPECT_GE(row["smallest_distance_m"], -1e-9) << row;
      EXPECT_LE(row["largest_joint_error_m"], 1e-9) << row;
    }
  }
}

TEST_F(StudyProgram, AnInterruptedStudyKeepsThoseBeforeItAndNamesTheCommandForTheRest) {
  const auto amid = [&](const std::string& names, int signal, const std::function<bool()>& ready) {
    write(".out", "");
    const int status = signal_amid("study " + names + " --quick --out out", signal, ready);
    EXPECT_TRUE(WIFEXITED(status));
    return WEXITSTATUS(status);
  };
  const auto begun = [&](const char* study) {
    return [&, study] { return text(".out").find(std::string("== ") + study) != std::string::npos; };
  };
  EXPECT_EQ(amid("precision scaling", SIGTERM, begun("precision")), 143);
  EXPECT_EQ(text(".err"), "graphsolve: study: stopped by signal 15; what is left: graphsolve study precision scaling "
                          "--quick --out 'out'\n");
  EXPECT_TRUE(fs::is_empty(folder_ / "out"));
  EXPECT_EQ(amid("scaling precision", SIGINT, begun("precision")), 130);
  EXPECT_TRUE(text(".err").ends_with(
      "graphsolve: study: stopped by signal 2; what is left: graphsolve study precision --quick --out 'out'\n"))
      << text(".err");
  EXPECT_TRUE(nlohmann::json::accept(text("out/scaling.json")));
  EXPECT_FALSE(fs::exists(folder_ / "out/precision.json"));
}

}  // namespace test_study
