#include "sim/fem/kernels/parts.h"

#define LIMBERG_WORD(x) #x
#define LIMBERG_NAME(x) LIMBERG_WORD(x)

namespace limberg::fem::LIMBERG_SET {

const Kernels kernels = {LIMBERG_NAME(LIMBERG_SET),
                         evaluate_tile,
                         sum_slots,
                         update_multipliers,
                         viscous_cells,
                         dot,
                         add_scaled,
                         add_scaled_dot,
                         combine,
                         subtract,
                         subtract_outer,
                         max_square,
                         all_finite,
                         panels_forward,
                         panels_backward,
                         multiply_transposed,
                         factor_panel,
                         scale_nodes,
                         residual,
                         relax,
                         weigh,
                         weigh_add};

}  // namespace limberg::fem::LIMBERG_SET
