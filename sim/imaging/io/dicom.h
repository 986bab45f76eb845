#pragma once
// DICOM series: slices, one file each or all in one, in a folder as a disc holds them.
//
// A folder is walked with its subfolders, eight deep and 20,000 entries at most; a link back to a folder that was
// walked leads nowhere. A DICOMDIR stands for its folder, another file for its series among the files beside it. Files
// that are no DICOM or have no pixels are passed over, and so is a file that cannot be parsed: it is named in the
// notes, and refused only when nothing is left. The same slice in two folders is read once.
//
// Read: Explicit and Implicit VR little endian, one number of 8 or 16 bits per pixel. A file of several frames
// (Enhanced CT) says in a group for each where it lies; its stacks are series of their own. Other sequences are
// skipped. Pixels are plain, run lengths, or (where GDCM is installed) JPEG, JPEG-LS and JPEG 2000. Slices are sorted
// by where they lie along the normal of their plane, not by name. Values are made with slope and intercept; padding and
// what is below -1500 becomes air (-1000, or the least other number where that is higher). A gantry that was tilted
// (slices that drift in their own plane) and gaps that are uneven are evened out by linear interpolation on an
// orthogonal grid. Refused: slices missing from an even series (unless they are to be bridged), gaps above 10 mm, two
// slices at one place, slices of different size, spacing or direction, frames that do not say where they lie. Whatever
// was done is said in the notes of what is loaded. (DICOM PS3.3 C.7.6.2, C.7.6.16, C.11.1; PS3.5 chapter 7, annexes A.4
// and G.)
#include <string>
#include <string_view>
#include <vector>

#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

bool looks_like_dicom(std::string_view head);
/// settings.series: a number from 1 in the order of their first files' names, a UID, or a part of the description; may
/// be empty where there is one. InputError: several and none asked for (all are listed), or what load_volume and the
/// text above refuse.
LoadedVolume load_dicom(const std::string& path, const LoadSettings& settings);

/// What a series is, without its pixels.
struct SeriesAbout {
  int number = 0;  // from 1, as load_dicom takes it
  std::string uid, description, modality, body_part, kernel;
  std::string patient;     // PatientID
  std::string image_type;  // ORIGINAL\PRIMARY\AXIAL
  int slices = 0, columns = 0, rows = 0;
  double column_step_mm = 0, row_step_mm = 0;  // between pixels of a row, between rows
  double gap_mm = 0;                           // between slices, the median
  Vec3 extent_mm = Vec3::Zero();               // along rows, along columns, from the first slice to the last
  double height_mm = 0;                        // how much of the patient's length (z) it covers
  double tilt_deg = 0;                         // of the gantry; above 0: slices move towards `down` along their normal
  bool axial = false;                          // the slices' normal is nearer to z than to x or y
  std::string refused;  // why it cannot be read; empty: it can, as far as is known without its pixels
};
/// All series of a folder, a DICOMDIR or the folder of a slice. InputError: none.
std::vector<SeriesAbout> list_series(const std::string& path, const LoadSettings& settings = {});
/// One line: number, modality, description, slices.
std::string line_of(const SeriesAbout& s);

struct SeriesChoice {
  int index = -1;                     // into the list; -1: none will do
  std::string why;                    // a sentence or two
  std::vector<std::string> rejected;  // one sentence for each of the others that will not do
};
/// The series that shows a head best. Of CT, or of MR where no CT will do, can be read, is neither a localizer nor
/// derived nor a secondary capture (Image Type), has 12 slices and covers 80 mm of the patient's length: those whose
/// body part is none but the head, if any; of these, those that cover at least nine tenths of what the best does
/// (beyond 260 mm there is no head); of these, the finest slices; of these, the first, whatever its kernel.
SeriesChoice choose_series(const std::vector<SeriesAbout>& list);

}  // namespace limberg::imaging
