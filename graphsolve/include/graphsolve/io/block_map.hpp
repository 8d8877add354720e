#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "graphsolve/block_detection.hpp"
#include "graphsolve/io/file_error.hpp"

namespace graphsolve::io {

/// Names, sizes and kinds of the blocks of a matrix, and what is known of their couplings: docs/block_map.md.
struct BlockMap {
  std::vector<Block> blocks;
  std::vector<BlockCoupling> couplings;
};

/// Reads a block map: JSON of format `graphsolve-blocks`, or a plain list of block sizes (numbers, separated by blanks,
/// commas or lines, with or without brackets). Checks the schema, and that no key is given twice; whether the blocks
/// cover a matrix is checked by make_blocks. Throws FileError that names the place: "map.json:5: blocks[2].kind: 'sadle' is no kind ...".
BlockMap read_block_map(const std::string& path);
/// The same from text; `name` is what errors call it.
BlockMap parse_block_map(std::string_view text, std::string_view name = "blocks.json");

/// The map of a structure, such as detection has found: read again it gives the same graph and numbering.
/// But for couplings of unknown rank that the pattern of the matrix has not: a structure does not tell these from others.
BlockMap block_map(const BlockStructure& structure);
/// One block per line, to be read and edited. Throws std::invalid_argument when a name is not UTF-8, naming the block.
std::string block_map_json(const BlockMap& map);

}  // namespace graphsolve::io
