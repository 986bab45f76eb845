#pragma once
// What became of a head: fragments, gaps, landmarks, cephalometry before and after, in result.json and on paper.
#include <string>
#include <vector>

#include "app/result/result.h"
#include "app/session/solver_lane.h"
#include "app/words/words.h"
#include "render/view.h"
#include "sim/skull/head/head.h"

namespace limberg {

/// `head` {fragments, gaps, fits, landmarks, face_moved_max_mm, tissues}, tables for the report, and `gallery`: the
/// pictures that draw_head_pictures leaves.
void fill_head(Result& result, const Head& head);
void print_head(const Head& head);
/// DIR/measures.csv (measures.h), and the skull beside a normal one and its mirror image (skull_comparison.h).
void leave_head_figures(Result& result, const Head& head, const std::vector<std::string>& normal_files,
                        const std::string& dir, const Snapshot& last, const Camera& camera, Workers& workers);

/// Draws DIR/overview.png, the stages, and DIR/head/*.png: face and bones before and after, the map of displacement,
/// the net of the tissue. `first`: when nothing had been done; at the end the rest of bones may be another (of two that
/// were joined).
/// `camera`: the scene's. Says in one line when pictures cannot be made here. False: as draw_report_pictures.
bool draw_head_pictures(const std::string& dir, const std::vector<StageRow>& stages, const Snapshot& first,
                        const Snapshot& last, const Camera& camera, const Head& head, const Words& w = {});

}  // namespace limberg
