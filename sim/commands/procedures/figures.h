#pragma once
// The figures of the catalogue, one function each. Lengths in mm, angles in degrees.
#include "sim/commands/procedures/figure.h"

namespace limberg::figures {

/// Two equal arcs through (+-length/2, 0); vertex angle 4 atan(width / length), each scar half an arc's length long.
Figure fusiform(double width_mm, double ratio);
/// The same with its right tip replaced by an M: the arcs are kept to where the
/// wound is tip_share of its width, and a tongue of tissue reaches in between so
/// far that each of the two small tips has tip_deg. Shorter scar, two small ears
/// for one. InputError where the arcs close so fast that the tongue has no room.
Figure m_plasty(double width_mm, double ratio, double tip_share, double tip_deg);

/// Limberg's flap for a rhombus ABCD with angle_deg at A and C: D-E
/// prolongs the short diagonal by one side, E-F is parallel to DC.
Figure rhomboid(double side_mm, double angle_deg);
/// Dufourmentel: D-E bisects the angle between the prolonged short diagonal
/// and the prolonged side CD, E-F is parallel to the long diagonal.
Figure dufourmentel(double side_mm, double angle_deg);
/// Webster: D-E as Dufourmentel's, the flap's tip E has tip_deg
/// (30). The M-plasty that Webster adds at the base is not drawn.
Figure webster(double side_mm, double tip_deg);

/// Central limb AB along y, lateral limbs of the same length at angle_a_deg (at A) and angle_b_deg (at B).
Figure z_plasty(double limb_mm, double angle_a_deg, double angle_b_deg);
/// `count` equal Z-plasties whose central limbs follow each other along y, length_mm in all.
Figure multiple_z(double length_mm, int count, double angle_deg);
/// Four flaps: a Z-plasty of twice angle_deg whose two flaps are halved.
Figure four_flap_z(double limb_mm, double angle_deg);

/// A triangular island, base width_mm on the defect's edge, brought forward by advance_mm into a rectangular defect.
Figure v_y(double width_mm, double height_mm, double advance_mm);
/// A spindle-shaped defect of width_mm and length / width `ratio`; beside it an island flap_ratio as wide, whose ends
/// stand at right angles to the defect's edge and whose far side is concentric with it. It comes over the defect, and
/// the skin at its two far corners closes as a V to a Y, v_mm long (Behan 2003, ANZ J Surg 73, 112).
Figure keystone(double width_mm, double ratio, double flap_ratio, double v_mm);
/// A square defect, a flap of its width and length_mm, and Burow's triangles of the same base at the flap's foot.
Figure advancement(double width_mm, double length_mm, double burow_height_mm);
/// A triangular defect of defect_deg at the centre of a circle; a flap of arc_deg of that circle turns over it.
Figure rotation(double radius_mm, double defect_deg, double arc_deg);
/// Bilobed: a round defect with a triangle to the pivot; two lobes at turn_deg each about the pivot, the first as wide
/// as the defect, the second drawn out to a point so that its bed closes.
Figure bilobed(double diameter_mm, double turn_deg);
/// One lobe that turns by turn_deg into a round defect, its point tip_ratio radii of the defect beyond its middle: at
/// 1.6 its sides are as long as the half circles that they are sewn to, for what is longer piles up. The skin between
/// pivot and defect comes away as a triangle (banner flap; as a nasolabial flap it lies along the fold).
Figure banner(double diameter_mm, double turn_deg, double tip_ratio);
/// A round defect and two opposite arcs, each cut_ratio diameters long, that
/// leave it at tip_deg from its tangent and let two flaps turn towards each other.
Figure o_to_z(double diameter_mm, double cut_ratio, double tip_deg);

}  // namespace limberg::figures
