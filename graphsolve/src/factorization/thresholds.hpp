#pragma once

#include <limits>

/// What decides about pivots, all in one place. Each lies between what rounding leaves (eps = 2.2e-16 per operation, times
/// the growth that is let through) and the smallest thing of meaning that scenes, programs and matrices were seen to have.
namespace graphsolve::thresholds {

// Exchanges of rows.
/// The diagonal entry is taken when it is at least this part of the largest: definite blocks then need no exchanges,
/// whose branches cost more than the arithmetic. Entries grow at most by 1 + 1 / this per stage.
inline constexpr double diagonal_preferred = 0.1;
/// In packs, which exchange nothing: a block whose elimination grows by more than this, or loses more than that of a
/// diagonal entry, goes alone. Two digits of growth are what a sweep of refinement gains back; what loses 13 digits may be
/// all rounding, and is looked at for dependence or boosted there. Both compare with the entry itself: units do not matter.
inline constexpr double most_growth = 64;
inline constexpr double least_rest = 1e-13;

// Rows that depend on others. What is left of them is rounding of what was added, eps times a growth of up to 1e4.
/// A pivot of a block that may depend is rounding below this part of what was added to it.
inline constexpr double dependent = 1e-11;
/// Such a row still couples to a later column where what remains is more than this part of the column's largest entry,
/// and more than that part of what it was made of: then it was not dependent, only early. The first is larger than
/// sqrt(eps): a column may be a difference of its own.
inline constexpr double couples = 1e-8;
inline constexpr double couples_of_made = dependent;
/// Both where the row is evaluated anew in every iteration, and shifted else (Factorization::set_saddle_shift): what a
/// constraint of curved ones still couples on the way to where it depends is what they are open by, over their size, seldom
/// more than this; a row that is only early has couplings like all others. What is left out gains a digit per iteration then.
inline constexpr double couples_on_the_way = 0.1;

// Other pivots of symmetric matrices, and those of blocks that refinement has to make good.
inline constexpr double tiny = 1e-13;    ///< below this part of its row's size a pivot is boosted: as least_rest
inline constexpr double boosted = 1e-7;  ///< to this part: refinement divides the error by its inverse, once per sweep
/// Of its own diagonal entry, below which a pivot is not positive for Cholesky: the rounding of the last subtraction.
inline constexpr double not_positive = 4 * std::numeric_limits<double>::epsilon();

/// The reciprocal of a smaller pivot may be no number, whatever it is compared with.
inline constexpr double least_pivot = std::numeric_limits<double>::min();

/// Componentwise backward error that refinement is content with.
inline constexpr double refined = 4 * std::numeric_limits<double>::epsilon();

}  // namespace graphsolve::thresholds
