#pragma once
// NIfTI-1 (.nii, .nii.gz, and .hdr beside an .img): three dimensions (a fourth of one), integers or floats of either
// byte order, scaled by scl_slope and scl_inter. Place: the sform where there is one, else the qform, else the spacing;
// its frame is right, anterior, superior and is turned to left, posterior, superior. Lengths in m, mm or um as the
// header says (unknown: mm).
// (NIfTI-1 data format, 2007: header of 348 bytes.)
#include <string>
#include <string_view>

#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

/// From its first bytes, compressed or not.
bool looks_like_nifti(std::string_view head);
/// Throws InputError as load_volume does.
Volume load_nifti(const std::string& path);

}  // namespace limberg::imaging
