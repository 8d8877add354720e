#include "wrong_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <vector>

// The library says "1 required N missing", and about words that it did not expect nothing but the words.

namespace cli {

namespace {

/// The name of an error may be that of its command.
bool is(const CLI::Error& error, CLI::ExitCodes kind) { return error.get_exit_code() == static_cast<int>(kind); }

std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_lnames().empty()) names.push_back("--" + option->get_lnames().front());
  return names;
}

std::string about_word(const CLI::App& command, const std::string& word) {
  const auto known = options_of(command);
  // Behind "--" an option is a word like others.
  if (!word.starts_with('-') || std::ranges::find(known, word) != known.end()) return fmt::format("'{}' is one word too many", word);
  return fmt::format("there is no option '{}'; there are: {}", word.substr(0, word.find('=')),
                     fmt::join(known, ", "));
}

/// The name of the option is only in the text, at its front; that of a flag without dashes.
const CLI::Option* option_of(const CLI::App& command, std::string_view text) {
  const std::string name(text.substr(0, text.find_first_of(": ")));
  const CLI::Option* option = command.get_option_no_throw(name);
  return option ? option : command.get_option_no_throw("--" + name);
}

}  // namespace

std::string sentence_about(const CLI::App& program, const CLI::Error& error) {
  const auto begun = program.get_subcommands();
  const CLI::App& command = begun.empty() ? program : *begun.front();
  const std::string text = error.what();
  std::vector<std::string> names;
  for (const CLI::App* name : program.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(name->get_name());
  const bool no_command = begun.empty() && !names.empty();
  if (is(error, CLI::ExitCodes::ExtrasError) || no_command) {
    const std::vector<std::string> words = program.remaining(true);
    if (!words.empty()) return about_word(command, words.front());
  }
  if (no_command) return fmt::format("a command is missing; there are: {}", fmt::join(names, ", "));
  const CLI::Option* option = option_of(command, text);
  if (!option) return text;
  const std::string name = option->get_name();
  if (is(error, CLI::ExitCodes::RequiredError)) return fmt::format("{} is missing: {}", name, option->get_description());
  if (!is(error, CLI::ExitCodes::ArgumentMismatch)) return text;
  if (option->get_items_expected_max() == 0) return name + " takes no value";
  if (option->count() > 1) return name + " is given more than once";
  return fmt::format("{} needs a value, {}: {}", name, option->get_type_name(), option->get_description());
}

}  // namespace cli
