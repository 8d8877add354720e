#pragma once

#include <cstdint>
#include <string_view>

namespace graphsolve::io {

/// Line, from 1, where the value at a path such as "blocks[2].kind" begins in a text that is valid JSON, or in a plain
/// list of numbers ("[2]"). The last value on the way that is there counts.
std::int64_t line_of(std::string_view text, std::string_view path);

}  // namespace graphsolve::io
