#pragma once

#include <optional>
#include <string>
#include <vector>

#include "support/problem_families.hpp"

/// Problems that nobody here wrote: matrices and pose graphs of ../shared/data, beside the source directory.
namespace families {

/// Where they are, or nothing: then tests say "skipped, no data".
std::optional<std::string> data_directory();

/// Names of the matrices (Matrix Market files without ending), sorted.
std::vector<std::string> real_matrices();
/// One scalar node per row, all regular; rows that have no diagonal entry are semidefinite. Files that hold a pattern
/// get seeded values that make the matrix positive definite. The pattern is made symmetric by explicit zeros.
Problem real_matrix(const std::string& name);

/// Names of the pose graphs (.g2o files without ending), sorted.
std::vector<std::string> pose_graphs();
/// The normal matrix J' W J of a pose graph at its initial guess (where the file has none, the poses that follow from
/// the edges i -> i + 1), the first pose held: nodes of 3 (plane) or 6 rows (space), one per further pose. The
/// derivative of the log of the error is taken as 1, which is exact where an edge is satisfied.
Problem pose_graph(const std::string& name);

}  // namespace families
