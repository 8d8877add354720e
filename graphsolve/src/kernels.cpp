#include "kernels.hpp"

#include <array>

namespace graphsolve::kernels {

namespace {

constexpr int sizes = max_fixed + 1;

template <int... I>
constexpr std::array<ProductKernel, sizeof...(I)> product_table(std::integer_sequence<int, I...>) {
  // Entry m * sizes + k; either being 0 stands for "any size".
  return {(I / sizes == 0 || I % sizes == 0 ? &subtract_product<0, 0> : &subtract_product<I / sizes, I % sizes>)...};
}
template <int... I>
constexpr std::array<StridedKernel, sizeof...(I)> strided_table(std::integer_sequence<int, I...>) {
  return {(I / sizes == 0 || I % sizes == 0 ? &subtract_product_strided<0, 0>
                                            : &subtract_product_strided<I / sizes, I % sizes>)...};
}
template <int... I>
constexpr std::array<LowerKernel, sizeof...(I)> lower_table(std::integer_sequence<int, I...>) {
  return {(I / sizes == 0 || I % sizes == 0 ? &subtract_product_lower<0, 0>
                                            : &subtract_product_lower<I / sizes, I % sizes>)...};
}
template <int... I>
constexpr std::array<FactorKernel, sizeof...(I)> factor_table(std::integer_sequence<int, I...>) {
  return {&factor<I>...};
}
template <int... I>
constexpr std::array<DefiniteKernel, sizeof...(I)> definite_table(std::integer_sequence<int, I...>) {
  return {&factor_definite<I>...};
}
template <int... I>
constexpr std::array<SolveKernel, sizeof...(I)> solve_table(std::integer_sequence<int, I...>) {
  return {&solve_block<I>...};
}

constexpr auto products = product_table(std::make_integer_sequence<int, sizes * sizes>{});
constexpr auto strided = strided_table(std::make_integer_sequence<int, sizes * sizes>{});
constexpr auto lowers = lower_table(std::make_integer_sequence<int, sizes * sizes>{});
constexpr auto definites = definite_table(std::make_integer_sequence<int, sizes>{});
constexpr auto factors = factor_table(std::make_integer_sequence<int, sizes>{});
constexpr auto solves = solve_table(std::make_integer_sequence<int, sizes>{});

constexpr int fixed(int d) { return d <= max_fixed ? d : 0; }

}  // namespace

ProductKernel product_kernel(int m, int k) { return products[fixed(m) * sizes + fixed(k)]; }
StridedKernel strided_kernel(int m, int k) { return strided[fixed(m) * sizes + fixed(k)]; }
LowerKernel lower_kernel(int m, int k) { return lowers[fixed(m) * sizes + fixed(k)]; }
DefiniteKernel definite_kernel(int d) { return definites[fixed(d)]; }
FactorKernel factor_kernel(int d) { return factors[fixed(d)]; }
SolveKernel solve_kernel(int d) { return solves[fixed(d)]; }

}  // namespace graphsolve::kernels
