// Links one function of every package that the find modules promise, so that a wrong path or a missing dependency of
// a library shows. Expected: prints "all linked" and ends with 0.

#include <amd.h>
#include <camd.h>
#include <cholmod.h>
#include <colamd.h>
#include <klu.h>
#include <metis.h>
#include <umfpack.h>

#include <cstdio>

int main() {
  double control[UMFPACK_CONTROL];
  amd_defaults(control);
  camd_defaults(control);
  colamd_set_defaults(control);
  umfpack_di_defaults(control);
  klu_common klu;
  cholmod_common cholmod;
  idx_t metis[METIS_NOPTIONS];
  const bool fine = klu_defaults(&klu) == 1 && cholmod_start(&cholmod) == 1 && cholmod_finish(&cholmod) == 1 &&
                    METIS_SetDefaultOptions(metis) == METIS_OK;
  std::puts(fine ? "all linked" : "a library refused its defaults");
  return fine ? 0 : 1;
}
