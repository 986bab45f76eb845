#pragma once
// DICOM series: a folder of slices, one file each (or one of its files, which stands for its series).
//
// Read: Explicit and Implicit VR little endian, not compressed, one number of 8 or 16 bits per pixel,
// one frame per file; sequences are skipped. Slices are sorted by where they lie along the normal of
// their plane, not by name. Values are made with slope and intercept; padding and what is below -1500
// becomes air (-1000, or the least other number where that is higher). A gantry that was tilted (slices
// that drift in their own plane) and gaps that are uneven are evened out by linear interpolation on an
// orthogonal grid. Refused: slices missing from an even series, gaps above 10 mm, two slices at one
// place, slices of different size, spacing or direction. Compressed files are read where the program
// was built with GDCM (-DLIMBERG_GDCM=ON). (DICOM PS3.3 C.7.6.2, C.11.1; PS3.5 chapter 7.)
#include <string>
#include <string_view>
#include <vector>

#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

bool looks_like_dicom(std::string_view head);
/// `series`: a number from 1 in the order of their first files' names, a UID, or a part of the description; may be
/// empty where there is one. Files of other kinds are passed over. InputError: several and none asked for (all are
/// listed), or what load_volume and the text above refuse.
Volume load_dicom(const std::string& path, const std::string& series);

/// Pixels of a compressed file as little-endian numbers; false: this build has no GDCM.
bool gdcm_pixels(const std::string& file, size_t bytes, std::string& out);

}  // namespace limberg::imaging
