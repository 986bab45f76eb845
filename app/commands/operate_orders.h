#pragma once
#include <memory>
#include <string>
#include <vector>

#include "app/commands/session_command.h"
#include "app/session/workers_pool.h"
#include "sim/body/body.h"
#include "sim/commands/script.h"

namespace limberg {

/// `operate --orders`: the same wound closed in several orders (app/assembly/orders.h), each to rest and each with a
/// verdict. `cell_mm` 0: the scene's. Exit status 3 where an order ends badly.
int compare_orders(const std::vector<std::string>& orders, double cell_mm, const CommonOptions& common,
                   const Scene& scene, const Script& script, const std::shared_ptr<const Body>& body,
                   WorkersPool& workers);

}  // namespace limberg
