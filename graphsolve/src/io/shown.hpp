#pragma once

#include <string>
#include <string_view>

namespace graphsolve::io {

/// A name or a word of a file as people can see it, in UTF-8 that XML, DOT and a terminal take: white space is a blank;
/// other control characters, U+FEFF, U+FFFE, U+FFFF and bytes that are not UTF-8 are U+FFFD, the sign for what cannot be shown.
std::string shown(std::string_view text);

}  // namespace graphsolve::io
