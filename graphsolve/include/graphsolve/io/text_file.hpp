#pragma once

#include <string>
#include <string_view>

#include "graphsolve/io/file_error.hpp"

/// Whole text files.
namespace graphsolve::io {

/// Writes text beside the file and renames it when complete: the file is never half written. Throws FileError.
void write_text(std::string_view text, const std::string& path);
/// Throws FileError when the file cannot be read, is no text (a zero byte), has a line that goes on and on (longest_line
/// characters pass, twice as many may not), or is no ordinary file and longer than 2^30 bytes.
std::string read_text(const std::string& path, std::size_t longest_line = std::string::npos);

}  // namespace graphsolve::io
