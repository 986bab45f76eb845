#pragma once
// What the numbers of a file of points or triangles are: such files do not say.
#include <string>

namespace CLI {
class App;
}

namespace limberg {

/// Of "mm", "cm", "m" or "inch".
double mm_of(const std::string& unit);

/// --unit, one of these; `what`: of which numbers.
void add_unit(CLI::App& command, std::string& unit, const std::string& what);

/// Of a length in numbers of a file: the units in which it would be from `least_mm` to `most_mm` long, as words of a
/// sentence: "--unit cm (120 mm) or --unit inch (305 mm)". Empty: none of them, or mm.
std::string likely_units(double length, double least_mm, double most_mm);

}  // namespace limberg
