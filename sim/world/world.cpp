#include "sim/world.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement.h"
#include "sim/cutting/blade_build.h"
#include "sim/geometry/skin.h"
#include "sim/hash.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/lattice/topology.h"
#include "sim/world/anchors.h"
#include "sim/world/rest_index.h"
#include "sim/world/tension_field.h"
