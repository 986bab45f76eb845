#pragma once
// Reading [head]; apart from scene_head.h because of what TOML brings along.
#include "app/scene/scene_head.h"
#include "app/scene/toml_table.h"

namespace limberg {

/// Nothing when the scene has no [head]. Throws InputError.
std::optional<HeadScene> read_head(const toml::table& root, const std::string& file);

}  // namespace limberg
