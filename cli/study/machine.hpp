#pragma once

#include <nlohmann/json.hpp>

namespace cli::study {

/// What a timing means nothing without: program, commit, date, compiler, flags, libraries, processor, load, and the
/// unit of measure.hpp.
nlohmann::ordered_json machine(double unit_nanoseconds);

/// The same in two lines.
std::string machine_for_people(const nlohmann::ordered_json& machine);

}  // namespace cli::study
