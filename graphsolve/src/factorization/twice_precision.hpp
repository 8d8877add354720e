#pragma once

#include <cmath>

namespace graphsolve {

/// high + low -= a x, as if in twice the precision: residuals of nearly exact solutions are nothing but what rounding
/// takes (Ogita, Rump, Oishi 2005, "Accurate sum and dot product").
inline void subtract_product(double& high, double& low, double a, double x) {
  const double product = a * x, product_error = std::fma(a, x, -product);
  const double sum = high - product, taken = high - sum;
  low += ((high - (sum + taken)) - (product - taken)) - product_error;
  high = sum;
}

}  // namespace graphsolve
