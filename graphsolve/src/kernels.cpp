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
constexpr std::array<FactorKernel, sizeof...(I)> factor_table(std::integer_sequence<int, I...>) {
  return {&factor<I>...};
}
template <int... I>
constexpr std::array<SolveKernel, sizeof...(I)> solve_table(std::integer_sequence<int, I...>) {
  return {&solve_block<I>...};
}

constexpr auto products = product_table(std::make_integer_sequence<int, sizes * sizes>{});
constexpr auto factors = factor_table(std::make_integer_sequence<int, sizes>{});
constexpr auto solves = solve_table(std::make_integer_sequence<int, sizes>{});

constexpr int fixed(int d) { return d <= max_fixed ? d : 0; }

}  // namespace

ProductKernel product_kernel(int m, int k) { return products[fixed(m) * sizes + fixed(k)]; }
FactorKernel factor_kernel(int d) { return factors[fixed(d)]; }
SolveKernel solve_kernel(int d) { return solves[fixed(d)]; }

}  // namespace graphsolve::kernels
