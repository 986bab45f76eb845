#pragma once
// toml++ as this house uses it; include it from .cpp files only, and never <toml++/toml.h> itself.
//
// The library guards its parser with asserts that a broken file can reach (3.3: a key that starts with a stray byte).
// Here they throw instead: catch both toml::parse_error and BrokenToml, or simply std::runtime_error. One header for
// all, so that every part of the program is built with the same settings.
#include <stdexcept>

namespace limberg {

struct BrokenToml : std::runtime_error {
  BrokenToml() : std::runtime_error("it cannot be parsed") {}
};

[[noreturn]] inline void throw_broken_toml() { throw BrokenToml(); }

}  // namespace limberg

#define TOML_ENABLE_FORMATTERS 1
#define TOML_ASSERT(condition) ((condition) ? static_cast<void>(0) : limberg::throw_broken_toml())
#include <toml++/toml.h>
