#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "graphsolve/io/matrix_market.hpp"
#include "graphsolve/io/text_file.hpp"
#include "matrix_cases.hpp"

namespace test_io_matrix_market {

namespace fs = std::filesystem;
using namespace graphsolve;
using namespace graphsolve::io;
using cases::any_double;
using cases::expect_same_bits;
using cases::mirrored;
using cases::random_matrix;

std::string file(const std::string& kind, const std::string& rest) {
  return "%%MatrixMarket matrix " + kind + "\n" + rest;
}

std::string error_of(const std::string& text) {
  try {
    (void)parse_matrix_market(text, "a.mtx");
  } catch (const FileError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MatrixMarket, AnyFiniteDoubleComesBackBitForBit) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SparseMatrix matrix = random_matrix(13, 9, seed);
    expect_same_bits(parse_matrix_market(matrix_market(matrix)).matrix, matrix);
  }
  const double extremes[] = {-0.0, 5e-324, 2.2250738585072009e-308, std::numeric_limits<double>::max(), 0.1, 1.0 / 3};
  std::vector<Triplet> triplets;
  for (int i = 0; i < 6; ++i) triplets.push_back({i, i, extremes[i]});
  const SparseMatrix matrix = from_triplets(6, 6, triplets);
  expect_same_bits(parse_matrix_market(matrix_market(matrix)).matrix, matrix);
}

TEST(MatrixMarket, SymmetricAndSkewFilesHoldOneTriangleAndComeBackWhole) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const auto symmetry : {Symmetry::symmetric, Symmetry::skew_symmetric}) {
      const SparseMatrix matrix = mirrored(11, symmetry == Symmetry::symmetric ? 1 : -1, seed);
      const std::string text = matrix_market(matrix, {.symmetry = symmetry});
      const MatrixFile back = parse_matrix_market(text);
      EXPECT_EQ(back.symmetry, symmetry);
      EXPECT_LT(std::count(text.begin(), text.end(), '\n'), matrix.entries() + 2);
      expect_same_bits(back.matrix, matrix);
    }
  }
}

TEST(MatrixMarket, DenseColumnsComeBackBitForBit) {
  std::mt19937_64 random(7);
  std::vector<double> values(24);
  for (double& value : values) value = any_double(random);
  const DenseMatrix back = parse_dense_matrix_market(matrix_market(values, 8, "a comment\nof two lines"));
  EXPECT_EQ(back.rows, 8);
  EXPECT_EQ(back.columns, 3);
  for (std::size_t k = 0; k < values.size(); ++k)
    EXPECT_EQ(std::bit_cast<std::uint64_t>(back.value[k]), std::bit_cast<std::uint64_t>(values[k]));
}

TEST(MatrixMarket, FilesOnDiskComeBackAndNothingElseIsLeft) {
  const fs::path folder = fs::path(testing::TempDir()) / "graphsolve_matrix_market";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const SparseMatrix matrix = random_matrix(5, 5, 3);
  write_text(matrix_market(matrix), (folder / "a.mtx").string());
  expect_same_bits(read_matrix_market((folder / "a.mtx").string()).matrix, matrix);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
  EXPECT_THROW(write_text("", (folder / "no" / "a.mtx").string()), FileError);
  // A file that happens to have the name of a half written one stays; so does a link.
  write_text("mine", (folder / "a.mtx.part").string());
  fs::create_symlink("a.mtx", folder / "link.mtx");
  write_text("new", (folder / "link.mtx").string());
  EXPECT_EQ(read_text((folder / "a.mtx.part").string()), "mine");
  EXPECT_EQ(read_text((folder / "a.mtx").string()), "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.mtx"));
  EXPECT_THROW((void)read_text((folder / "none.mtx").string()), FileError);
  EXPECT_THROW((void)read_text(folder.string()), FileError);
  fs::remove_all(folder);
}

TEST(MatrixMarket, PatternsHaveOnesAndIntegersTheirValue) {
  const MatrixFile pattern = parse_matrix_market(file("coordinate pattern symmetric", "3 3 3\n1 1\n3 1\n3 3\n"));
  EXPECT_EQ(pattern.field, Field::pattern);
  EXPECT_EQ(pattern.matrix.entries(), 4);
  for (const double value : pattern.matrix.value) EXPECT_EQ(value, 1);
  const MatrixFile integer = parse_matrix_market(file("coordinate integer general", "2 2 2\n1 2 -7\n2 1 +3\n"));
  EXPECT_EQ(integer.field, Field::integer);
  EXPECT_EQ(integer.matrix.value, (std::vector<double>{3, -7}));
  const std::string text = matrix_market(integer.matrix, {.field = Field::integer, .comment = "twice"});
  EXPECT_EQ(text, "%%MatrixMarket matrix coordinate integer general\n% twice\n2 2 2\n2 1 3\n1 2 -7\n");
  EXPECT_EQ(matrix_market(pattern.matrix, {.symmetry = Symmetry::symmetric, .field = Field::pattern}),
            "%%MatrixMarket matrix coordinate pattern symmetric\n3 3 3\n1 1\n3 1\n3 3\n");
}

TEST(MatrixMarket, RepeatedEntriesAreAddedAndCounted) {
  const MatrixFile general = parse_matrix_market(file("coordinate real general", "2 2 4\n1 1 1\n1 1 2\n2 1 4\n1 1 8\n"));
  EXPECT_EQ(general.repeated, 2);
  EXPECT_EQ(general.matrix.value, (std::vector<double>{11, 4}));
  const MatrixFile symmetric =
      parse_matrix_market(file("coordinate real symmetric", "2 2 5\n1 1 1\n2 1 2\n2 1 4\n1 1 8\n2 2 1\n"));
  EXPECT_EQ(symmetric.repeated, 2);
  EXPECT_EQ(symmetric.matrix.value, (std::vector<double>{9, 6, 6, 1}));
  const MatrixFile pattern = parse_matrix_market(file("coordinate pattern general", "1 1 2\n1 1\n1 1\n"));
  EXPECT_EQ(pattern.matrix.value, std::vector<double>{1});
}

TEST(MatrixMarket, ArraysOfEverySymmetryAreRead) {
  const MatrixFile symmetric = parse_matrix_market(file("array real symmetric", "2 2\n1\n2\n3\n"));
  EXPECT_EQ(symmetric.matrix.value, (std::vector<double>{1, 2, 2, 3}));
  const MatrixFile skew = parse_matrix_market(file("array real skew-symmetric", "2 2\n5\n"));
  EXPECT_EQ(skew.matrix.value, (std::vector<double>{5, -5}));
  const MatrixFile general = parse_matrix_market(file("array integer general", "2 2\n1\n0\n0\n4\n"));
  EXPECT_EQ(general.matrix.entries(), 2);
  const DenseMatrix sparse = parse_dense_matrix_market(file("coordinate real general", "3 1 2\n3 1 2.5\n3 1 1\n"));
  EXPECT_EQ(sparse.value, (std::vector<double>{0, 0, 3.5}));
}

TEST(MatrixMarket, BlanksCommentsAndWindowsLinesMayStandAnywhere) {
  const MatrixFile read = parse_matrix_market(
      "%%matrixmarket  MATRIX Coordinate Real General \r\n% a\r\n\r\n  2 2\t2\r\n\r\n 1  1 1e0 \r\n% b\r\n2 2 -.5\r\n\r\n");
  EXPECT_EQ(read.matrix.value, (std::vector<double>{1, -0.5}));
  EXPECT_EQ(parse_matrix_market(file("coordinate real general", "1 1 1\n1 1 3")).matrix.value[0], 3);
  // The smallest numbers round to zero or a denormal; that is no error.
  EXPECT_EQ(parse_matrix_market(file("coordinate real general", "1 1 1\n1 1 1e-400\n")).matrix.value[0], 0);
}

TEST(MatrixMarket, LinesMayAllEndInCrAndAByteOrderMarkMayStandFirst) {
  std::string text = file("coordinate real general", "% a\n2 2 2\n1 1 1\n\n2 2 -.5\n");
  EXPECT_EQ(parse_matrix_market("\xef\xbb\xbf" + text).matrix.value, (std::vector<double>{1, -0.5}));
  std::replace(text.begin(), text.end(), '\n', '\r');
  EXPECT_EQ(parse_matrix_market(text).matrix.value, (std::vector<double>{1, -0.5}));
  EXPECT_EQ(error_of(text + "1 1 1\r"), "a.mtx:7: a line follows the last entry: there are more than the size line says");
  // Nor is such a file one line to who reads it from disk.
  const std::string path = (fs::temp_directory_path() / "graphsolve_cr.mtx").string();
  std::string longer = file("array real general", "40000 1\n");
  for (int i = 0; i < 40000; ++i) longer += "1.5\n";
  std::replace(longer.begin(), longer.end(), '\n', '\r');
  write_text(longer, path);
  EXPECT_EQ(read_dense_matrix_market(path).value.back(), 1.5);
  fs::remove(path);
}

TEST(MatrixMarket, IntegersThatADoubleRoundsAreRefused) {
  const std::string largest = "9007199254740992";
  const auto entry = [](const std::string& value) {
    return error_of(file("coordinate integer general", "1 1 1\n1 1 " + value + "\n"));
  };
  EXPECT_EQ(entry(largest), "accepted");
  EXPECT_EQ(entry("-" + largest), "accepted");
  const std::string beyond = " lies beyond 2^53, where a double does not hold every integer";
  EXPECT_EQ(entry("9007199254740993"), "a.mtx:3: the value 9007199254740993" + beyond);
  EXPECT_EQ(entry("-9007199254740994"), "a.mtx:3: the value -9007199254740994" + beyond);
  EXPECT_EQ(entry("99999999999999999999"), "a.mtx:3: the value '99999999999999999999' is too large");
  const std::string sum = file("coordinate integer general", "1 1 2\n1 1 " + largest + "\n1 1 2\n");
  EXPECT_EQ(error_of(sum), "a.mtx: the repeated entries (1, 1) add up to an integer beyond 2^53, where a double does not "
                           "hold every one");
  EXPECT_THROW((void)parse_dense_matrix_market(sum), FileError);
  EXPECT_EQ(error_of(file("coordinate real general", "1 1 1\n1 1 9007199254740993\n")), "accepted") << "reals are rounded";
}

TEST(MatrixMarket, EveryMalformedFirstLineIsNamed) {
  const std::string begins = "a.mtx:1: this is no Matrix Market file: it begins with ";
  EXPECT_EQ(error_of("%MatrixMarket matrix\n"), begins + "'%MatrixMarket', not '%%MatrixMarket'");
  EXPECT_EQ(error_of("\xff\x01%%MatrixMarket\n"), begins + "'\xef\xbf\xbd\xef\xbf\xbd%%MatrixMarket', not '%%MatrixMarket'");
  EXPECT_EQ(error_of("%%MatrixMarket Vector array real general\n"), "a.mtx:1: the object must be 'matrix', not 'Vector'");
  EXPECT_EQ(error_of(""), "a.mtx: the file is empty");
  EXPECT_EQ(error_of("1 1 1\n"),
            "a.mtx:1: this is no Matrix Market file: it begins with '1', not '%%MatrixMarket'");
  EXPECT_EQ(error_of("%%MatrixMarket vector array real general\n"), "a.mtx:1: the object must be 'matrix', not 'vector'");
  EXPECT_EQ(error_of(file("elemental real general", "")),
            "a.mtx:1: the format must be 'coordinate' or 'array', not 'elemental'");
  EXPECT_EQ(error_of(file("coordinate complex general", "")), "a.mtx:1: complex values are not supported");
  EXPECT_EQ(error_of(file("coordinate quaternary general", "")),
            "a.mtx:1: the field must be 'real', 'integer' or 'pattern', not 'quaternary'");
  EXPECT_EQ(error_of(file("coordinate real hermitian", "")), "a.mtx:1: Hermitian matrices are not supported");
  EXPECT_EQ(error_of(file("coordinate real", "")),
            "a.mtx:1: the symmetry must be 'general', 'symmetric' or 'skew-symmetric', not ''");
  EXPECT_EQ(error_of(file("coordinate real general extra", "")), "a.mtx:1: 'extra' follows where the line should end");
  EXPECT_EQ(error_of(file("array pattern general", "")), "a.mtx:1: an 'array' cannot be a 'pattern'");
  EXPECT_EQ(error_of(file("coordinate pattern skew-symmetric", "")),
            "a.mtx:1: a 'pattern' cannot be 'skew-symmetric'");
}

TEST(MatrixMarket, EveryMalformedSizeLineIsNamed) {
  const auto size = [](const std::string& line) { return error_of(file("coordinate real general", line)); };
  EXPECT_EQ(size("% nothing\n"), "a.mtx: the size line is missing");
  EXPECT_EQ(size("2 2\n"), "a.mtx:2: the number of entries is missing");
  EXPECT_EQ(size("2 2 1 1\n"), "a.mtx:2: '1' follows where the line should end");
  EXPECT_EQ(size("-2 2 1\n"), "a.mtx:2: the number of rows -2 is negative");
  EXPECT_EQ(size("2 2 -1\n"), "a.mtx:2: the number of entries -1 is negative");
  EXPECT_EQ(size("2 two 1\n"), "a.mtx:2: the number of columns 'two' is no integer");
  EXPECT_EQ(size("2.5 2 1\n"), "a.mtx:2: the number of rows '2.5' is no integer");
  EXPECT_EQ(size("3000000000 2 1\n"), "a.mtx:2: the number of rows 3000000000 is more than the 2147483647 supported");
  EXPECT_EQ(size("99999999999999999999 2 1\n"), "a.mtx:2: the number of rows '99999999999999999999' is too large");
  EXPECT_EQ(size("2000000000 2000000000 1\n1 1 1\n"),
            "a.mtx:2: the number of rows 2000000000 is more than a file of 76 bytes can fill");
  EXPECT_EQ(error_of(file("coordinate real symmetric", "2 3 1\n")),
            "a.mtx:2: a symmetric matrix must be square, not 2 x 3");
  // A count that nothing backs allocates nothing.
  EXPECT_EQ(size("2 2 9000000000000000000\n1 1 1\n"),
            "a.mtx: the file ends after 1 of 9000000000000000000 entries");
  EXPECT_THROW((void)parse_dense_matrix_market(file("coordinate real general", "9000 9000 1\n1 1 1\n")), FileError);
}

TEST(MatrixMarket, EveryMalformedEntryIsNamedWithLineAndValue) {
  const auto entry = [](const std::string& line) { return error_of(file("coordinate real general", "2 3 1\n" + line)); };
  EXPECT_EQ(entry(""), "a.mtx: the file ends after 0 of 1 entries");
  EXPECT_EQ(entry("1 1 1\n2 2 2\n"), "a.mtx:4: a line follows the last entry: there are more than the size line says");
  EXPECT_EQ(entry("0 1 1\n"), "a.mtx:3: row 0 lies outside of 1 .. 2");
  EXPECT_EQ(entry("3 1 1\n"), "a.mtx:3: row 3 lies outside of 1 .. 2");
  EXPECT_EQ(entry("\n% x\n1 4 1\n"), "a.mtx:5: column 4 lies outside of 1 .. 3");
  EXPECT_EQ(entry("1\n"), "a.mtx:3: the column is missing");
  EXPECT_EQ(entry("1 1\n"), "a.mtx:3: the value is missing");
  EXPECT_EQ(entry("1 1 1 1\n"), "a.mtx:3: '1' follows where the line should end");
  EXPECT_EQ(entry("1 1 x\n"), "a.mtx:3: the value 'x' is no number");
  EXPECT_EQ(entry("1 1 1.5.2\n"), "a.mtx:3: the value '1.5.2' is no number");
  EXPECT_EQ(entry("1 1 +-1\n"), "a.mtx:3: the value '+-1' is no number");
  EXPECT_EQ(entry("1 1 nan\n"), "a.mtx:3: the value 'nan' is not finite");
  EXPECT_EQ(entry("1 1 -inf\n"), "a.mtx:3: the value '-inf' is not finite");
  EXPECT_EQ(entry("1 1 1e400\n"), "a.mtx:3: the value '1e400' is too large");
  EXPECT_EQ(error_of(file("coordinate integer general", "1 1 1\n1 1 1.5\n")), "a.mtx:3: the value '1.5' is no integer");
  EXPECT_EQ(error_of(file("coordinate pattern general", "1 1 1\n1 1 1\n")),
            "a.mtx:3: '1' follows where the line should end");
  EXPECT_EQ(error_of(file("coordinate real symmetric", "2 2 1\n1 2 1\n")),
            "a.mtx:3: entry (1, 2) lies above the diagonal: a symmetric file stores the lower triangle");
  EXPECT_EQ(error_of(file("coordinate real skew-symmetric", "2 2 1\n2 2 1\n")),
            "a.mtx:3: entry (2, 2) is not below the diagonal: a skew-symmetric file stores the lower triangle without "
            "diagonal");
  EXPECT_EQ(error_of(file("array real general", "2 2\n1\n2\n3\n")), "a.mtx: the file ends after 3 of 4 entries");
  EXPECT_EQ(error_of(file("array real general", "1 1\n1 2\n")), "a.mtx:3: '2' follows where the line should end");
  EXPECT_EQ(entry("1 1 1e308\n"), "accepted");
  EXPECT_EQ(error_of(file("coordinate real general", "1 1 2\n1 1 1e308\n1 1 1e308\n")),
            "a.mtx: the repeated entries (1, 1) add up to no finite value");
}

TEST(MatrixMarket, NoCutAndNoChangedByteOfAFileCrashesTheReader) {
  const std::string whole = matrix_market(mirrored(6, 1, 5), {.symmetry = Symmetry::symmetric, .comment = "c"});
  int accepted = 0;
  std::mt19937_64 random(3);
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    accepted += error_of(whole.substr(0, cut)) == "accepted";
    std::string changed = whole;
    changed[cut] = static_cast<char>(random());
    (void)error_of(changed);
  }
  // What is cut inside the last number, or before the last line end, is still a file.
  EXPECT_LT(accepted, 25);
}

TEST(MatrixMarket, WhatCannotBeWrittenIsRefused) {
  const std::vector<Triplet> upper{{0, 1, 2.5}};
  const SparseMatrix matrix = from_triplets(2, 2, upper);
  EXPECT_THROW((void)matrix_market(matrix, {.symmetry = Symmetry::symmetric}), std::invalid_argument);
  EXPECT_THROW((void)matrix_market(matrix, {.field = Field::integer}), std::invalid_argument);
  const std::vector<Triplet> signs{{0, 1, 0.0}, {1, 0, -0.0}}, zeros{{0, 1, 0.0}, {1, 0, 0.0}};
  EXPECT_THROW((void)matrix_market(from_triplets(2, 2, signs), {.symmetry = Symmetry::symmetric}), std::invalid_argument);
  EXPECT_EQ(parse_matrix_market(matrix_market(from_triplets(2, 2, zeros), {.symmetry = Symmetry::skew_symmetric})).matrix.entries(), 2);
  const std::vector<Triplet> large{{0, 0, 0x1p53 + 2}};
  EXPECT_THROW((void)matrix_market(from_triplets(1, 1, large), {.field = Field::integer}), std::invalid_argument);
  const std::vector<Triplet> bad{{0, 0, std::nan("")}};
  EXPECT_THROW((void)matrix_market(from_triplets(1, 1, bad)), std::invalid_argument);
  EXPECT_THROW((void)matrix_market(std::vector<double>{1, 2, 3}, 2), std::invalid_argument);
}

TEST(RealMatrices, AllAreReadAndComeBackBitForBit) {
  const fs::path folder = fs::path(GRAPHSOLVE_SOURCE_DIR) / ".." / "shared" / "data" / "matrices";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "skipped, no data";
  int read = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".mtx") continue;
    const MatrixFile original = read_matrix_market(entry.path().string());
    const MatrixFile back =
        parse_matrix_market(matrix_market(original.matrix, {.symmetry = original.symmetry, .field = original.field}));
    SCOPED_TRACE(entry.path().string());
    EXPECT_GT(original.matrix.entries(), 0);
    expect_same_bits(back.matrix, original.matrix);
    ++read;
  }
  EXPECT_GE(read, 20);
}

}  // namespace test_io_matrix_market
