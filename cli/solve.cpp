#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "analyze_report.hpp"
#include "commands.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include "physics/mechanism.hpp"
#include "solve_engine.hpp"
#include "study/table.hpp"

namespace cli {

using namespace graphsolve;
using physics::DescriptionError;
using study::number;

namespace {

struct Options {
  std::string matrix, right, blocks, ordering = "minimum-fill", factorization = "auto", out;
  bool accept_singular = false, transposed = false;
  [[nodiscard]] System system() const { return transposed ? System::transposed : System::plain; }
};

constexpr const char* footer = R"(Examples:
  graphsolve solve A.mtx                        b = A * ones: how near to ones is x?
  graphsolve solve A.mtx b.mtx --out x.mtx      b may have several columns
  graphsolve solve A.mtx --blocks map.json --factorization ldlt
  graphsolve solve A.mtx b.mtx --transposed     A^T x = b, with the factors of A

With 'auto' a symmetric matrix of positive diagonal is tried by cholesky, then ldlt, then ldu; other symmetric ones by
ldlt, then ldu; the rest by ldu. What leaves a normwise backward error above 1e-12 is followed by the next, at last by
the robust chain (reordering, proximal shift, threshold pivoting); every attempt is reported. A pattern without values
gets seeded ones with a dominant diagonal.

A singular matrix is named as such, with the blocks in question, also where this right-hand side has solutions;
--accept-singular takes one of them. Numbers that leave the range of doubles on the way do not make a matrix singular.

Exit code: 0 solved, 1 the matrix is singular or no attempt was good enough (the blocks in question are named),
2 wrong input, a file that cannot be read or written, or fill beyond the memory of the machine.)";

std::optional<FactorizationKind> parse_kind(const std::string& text) {
  if (text == "auto") return std::nullopt;
  if (text == "ldu") return FactorizationKind::ldu;
  if (text == "ldlt") return FactorizationKind::ldlt;
  if (text == "cholesky") return FactorizationKind::cholesky;
  throw DescriptionError(fmt::format("there is no factorization '{}'; there are: auto, ldu, ldlt, cholesky", text));
}

/// Column-major.
io::DenseMatrix right_hand_side(const Options& options, const SparseMatrix& matrix) {
  io::DenseMatrix b{matrix.rows, 1, std::vector<double>(static_cast<std::size_t>(matrix.rows))};
  if (options.right.empty()) {
    const std::vector<double> ones(static_cast<std::size_t>(matrix.columns), 1.0);
    multiply(options.transposed ? transpose(matrix) : matrix, ones, b.value);
    for (std::size_t i = 0; i < b.value.size(); ++i)
      if (!std::isfinite(b.value[i]))
        throw DescriptionError(fmt::format("{}: row {} of {} * ones is {}: give a right-hand side", options.matrix, i + 1,
                                           options.transposed ? "A^T" : "A", b.value[i]));
    return b;
  }
  translate_errors(options.right, [&] { b = io::read_dense_matrix_market(options.right); });
  if (b.rows != matrix.rows || b.columns < 1)
    throw DescriptionError(fmt::format("{}: the right-hand side must have {} {} and a column at least, not {} x {}",
                                       options.right, matrix.rows, matrix.rows == 1 ? "row" : "rows", b.rows, b.columns));
  return b;
}

std::string scientific(double value) { return std::isfinite(value) ? fmt::format("{:.2e}", value) : "-"; }

std::string note_of(const SolveResult& result, const Attempt& attempt) {
  const bool last = &attempt == &result.attempts.back();
  if (attempt.trouble.empty()) return last && result.singular ? "singular" : "good";
  return last ? "failed" : "next";
}

/// Signs of boosted pivots are not known: they are no zeros.
std::string inertia_text(const Factorization::Outcome& o) {
  if (o.inertia == Inertia{}) return "-";
  const std::string text = fmt::format("{} {} {}", o.inertia.positive, o.inertia.negative, o.inertia.zero - o.boosts);
  return o.boosts == 0 ? text : fmt::format("{} ({}?)", text, o.boosts);
}

std::string inertia_sentence(const Factorization::Outcome& o) {
  if (o.inertia == Inertia{} || o.boosts == 0) return "";
  return fmt::format("inertia: at least {} positive, at least {} negative; {} without size of its own was boosted, its sign "
                     "is not known",
                     o.inertia.positive, o.inertia.negative,
                     o.boosts == 1 ? "one pivot" : fmt::format("each of {} pivots", o.boosts));
}

std::string attempts_text(const SolveResult& result) {
  study::Table table({"factorization", "normwise", "componentwise", "growth", "boosts", "dropped", "inertia (+ - 0)",
                      "sweeps", "setup ms", "factor ms", "solve ms", "note"});
  for (const Attempt& a : result.attempts) {
    const auto& o = a.outcome;
    table.add({a.method, scientific(a.error.normwise), scientific(a.error.componentwise),
               o.growth > 0 ? number(o.growth) : "-", fmt::format("{}", o.boosts),
               fmt::format("{}", o.dropped_rows),
               inertia_text(o),
               fmt::format("{}", a.sweeps), number(1e3 * a.setup_seconds), number(1e3 * a.factor_seconds),
               number(1e3 * a.solve_seconds), note_of(result, a)});
  }
  std::string text = table.text() + "\n";
  for (const Attempt& a : result.attempts)
    for (const std::string& sentence : {inertia_sentence(a.outcome), a.trouble, a.reason})
      if (!sentence.empty()) text += fmt::format("{}: {}\n", a.method, sentence);
  return text;
}

int solve(const Options& options) {
  const SolveRequest wanted{.ordering = parse_method(options.ordering),
                            .kind = parse_kind(options.factorization),
                            .system = options.system()};
  check_outputs({{"--out", options.out}}, {options.matrix, options.right, options.blocks});
  const MatrixSource source = load_matrix(options.matrix, options.blocks);
  const io::DenseMatrix b = right_hand_side(options, source.file.matrix);
  if (wanted.kind && *wanted.kind != FactorizationKind::ldu && !source.blocks.symmetric)
    throw DescriptionError(fmt::format("{}: {} needs a symmetric matrix", options.matrix, options.factorization));
  SolveRequest request = wanted;
  request.columns = b.columns;
  SolveResult result;
  translate_errors(options.matrix, [&] { result = solve_system(source, b.value, request); });
  std::string text = fmt::format("{}: {}\nordering {}, fill ratio {:.2f}, {}{}\n\n", options.matrix,
                                 describe(source, options.blocks), name(request.ordering), result.fill_ratio,
                                 count(b.columns, "right-hand side", "right-hand sides"),
                                 options.transposed ? " of A^T x = b" : "");
  text += attempts_text(result);
  if (options.right.empty() && std::isfinite(result.attempts.back().error.normwise)) {
    double error = 0;
    for (const double x : result.x) error = std::max(error, std::abs(x - 1));
    text += fmt::format("largest |x - 1|: {}\n", scientific(error));
  }
  const auto complain = [&] {
    fmt::print(stderr, "graphsolve: {}: {}\n", options.matrix,
               result.singular ? "the matrix is singular, or too near to it"
                               : "no attempt was good enough; the matrix was not found to be singular");
    for (const std::string& sentence : result.diagnosis) fmt::print(stderr, "graphsolve: {}\n", sentence);
  };
  if (!result.good || (result.singular && !options.accept_singular)) {
    fmt::print("{}", text);
    complain();
    if (result.good)
      fmt::print(stderr, "graphsolve: the right-hand side has solutions all the same; --accept-singular takes one\n");
    return step_failed;
  }
  std::vector<FileText> files;
  if (!options.out.empty())
    files.push_back({options.out, io::matrix_market(result.x, source.file.matrix.rows,
                                                    fmt::format("x of {} x = b, A = {}", options.transposed ? "A^T" : "A",
                                                                options.matrix))});
  write_and_print(files, text);
  if (!options.out.empty()) fmt::print("written: {}\n", options.out);
  if (result.singular) complain();
  return all_solved;
}

}  // namespace

Command add_solve(CLI::App& program) {
  CLI::App* command = program.add_subcommand("solve", "Solve a sparse linear system; report how well.");
  const auto options = std::make_shared<Options>();
  command->add_option("A.mtx", options->matrix, "The matrix, a Matrix Market file")->required()->type_name("");
  command->add_option("b.mtx", options->right, "Right-hand sides (default: A * ones; of A^T, A^T * ones)")->type_name("");
  const auto add = [&](const char* name, std::string& value, const char* type, const std::string& help) {
    return command->add_option(name, value, help)->type_name(type);
  };
  add("--blocks", options->blocks, "MAP", "Block map: JSON, or a list of sizes (default: found in the pattern)")->check(file_name());
  add("--ordering", options->ordering, "NAME", ordering_names())->capture_default_str();
  add("--factorization", options->factorization, "KIND", "auto, ldu, ldlt or cholesky")->capture_default_str();
  add("--out", options->out, "FILE", "The solution, a Matrix Market file; written when solved")->check(file_name());
  command->add_flag("--transposed", options->transposed, "Solve A^T x = b; errors are those of A^T, inertia and what is singular are of A");
  command->add_flag("--accept-singular", options->accept_singular, "Of a singular system that has solutions, take one");
  command->footer(footer);
  return [options] { return solve(*options); };
}

}  // namespace cli
