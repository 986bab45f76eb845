#pragma once
// The picture that a Wavefront file's material lays on a surface.
#include <string>
#include <string_view>

namespace limberg {

/// The file that the first mtllib of an OBJ names; empty: there is none.
std::string materials_of_obj(std::string_view text);

/// The file that the first map_Kd of a material file names, options passed over; empty: there is none.
/// Whatever else stands there is not looked at.
std::string picture_of_material(std::string_view text);

}  // namespace limberg
