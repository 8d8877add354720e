#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "graphsolve/io/file_error.hpp"
#include "graphsolve/sparse_matrix.hpp"

/// Matrix Market files (Boisvert, Pozo, Remington: The Matrix Market Exchange Formats, NISTIR 5935): `coordinate` and
/// `array`; real, integer and pattern; general, symmetric and skew-symmetric. Complex and Hermitian ones are refused.
/// Errors are FileErrors. Values that are not finite are refused: NaN never passes. So are, where the field is integer,
/// values beyond 2^53, where not every integer is a double.
namespace graphsolve::io {

enum class Field { real, integer, pattern };
enum class Symmetry { general, symmetric, skew_symmetric };

/// A matrix and how its file described it.
struct MatrixFile {
  SparseMatrix matrix;  ///< both triangles, whatever the file stored; a pattern has ones
  Field field = Field::real;
  Symmetry symmetry = Symmetry::general;
  std::int64_t repeated = 0;  ///< entries of the file at a place that had one already; they are added up
};

/// Reads a sparse matrix. Of an `array` file the zeros are left out. Lines end in LF or CR LF, or all of them in CR;
/// empty lines and comments may stand anywhere after the first line; a byte order mark of UTF-8 may stand before it.
/// Throws FileError: no such file, a line that is no entry, an index or a number out of range, too few or too many
/// entries, entries above the diagonal of a symmetric file, sizes beyond 2^31 - 1, and sizes that no file of this
/// length can fill (more than 64 rows or columns per byte), so that a wrong size line does not eat the memory; also what
/// read_text refuses, with lines of at most 65536 characters (the format allows 1024).
MatrixFile read_matrix_market(const std::string& path);
/// The same from text; `name` is what errors call it.
MatrixFile parse_matrix_market(std::string_view text, std::string_view name = "matrix.mtx");

/// Columns of numbers, such as right-hand sides: column-major, rows x columns.
struct DenseMatrix {
  int rows = 0;
  int columns = 0;
  std::vector<double> value;
};
/// Reads an `array` file, or a `coordinate` one whose missing entries are zeros. Throws FileError as above.
DenseMatrix read_dense_matrix_market(const std::string& path);
DenseMatrix parse_dense_matrix_market(std::string_view text, std::string_view name = "vector.mtx");

struct WriteOptions {
  Symmetry symmetry = Symmetry::general;  ///< symmetric, skew_symmetric: only the lower triangle is written
  Field field = Field::real;              ///< pattern: without values
  std::string comment = {};               ///< may have several lines
};
/// A coordinate file. Numbers have the fewest digits that read back as the same bits; of skew-symmetric matrices the
/// upper triangle reads back as the negative of the lower one, also in the sign of zeros, and integers know no -0.
/// Throws std::invalid_argument when the matrix has not the symmetry (symmetric: +0 opposite -0 has not), holds a value
/// that is not finite, or one that is no integer up to 2^53 where that is the field.
std::string matrix_market(const SparseMatrix& matrix, const WriteOptions& options = {});
/// An array file; values are column-major, as many as a multiple of `rows`.
std::string matrix_market(std::span<const double> values, int rows, std::string_view comment = {});

}  // namespace graphsolve::io
