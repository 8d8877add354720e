#pragma once

// For the kernels of graphsolve and physics; outside the version promise (docs/architecture.md).

/// Include before Highway: the instruction sets that code on packs is compiled for. Plain, AVX2 and AVX-512; what
/// lies between brings nothing and costs compile time.
#ifdef HWY_DISABLED_TARGETS
#undef HWY_DISABLED_TARGETS
#endif
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
