#pragma once

namespace graphsolve {

enum class Side { plain, transposed };  ///< A x = b or A^T x = b

}  // namespace graphsolve
