// Keys and mouse of the window, in one place. The mouse is that of radiology and surgery viewers: the left button does
// what is chosen, the right one turns, the middle one shifts, the wheel comes nearer.
#include "app/window/desk.h"
#include "render/quality.h"

namespace limberg {

const std::vector<DeskKey>& desk_keys() {
  static const std::vector<DeskKey> keys{
      {"left button", "use the tool; without a tool: turn"},
      {"right button", "turn the view"},
      {"middle button, Shift + right", "shift the view"},
      {"wheel", "nearer, farther; with a hook held: lift"},
      {"Space held", "clutch: the hands move, what they hold stays; then it follows from there"},
      {"1 or Esc", "look around"},
      {"2, 3, 4", "scalpel, undermine, excise"},
      {"5, 6, 7", "hook, stitch, row of stitches"},
      {"8, 9", "on bone: saw, grab a fragment"},
      {"F", "the face over the bones: solid, clear, hidden"},
      {"Ctrl+Z, Ctrl+Y", "undo, redo"},
      {"N", "show me the next step of the lesson"},
      {"T", "colours: tension of the skin (of a head: how far the face has moved), off"},
      {"V, Shift+V",
       "the next field in colours, the one before: stretch, area, stress, height, displacement, perfusion"},
      {"I", "iso-lines of the colours"},
      {"D", "directions in which the skin is stretched most and least"},
      {"L", "tension lines of the skin"},
      {"X", "lattice; cells of which there are several copies in orange"},
      {"B", "before and after: wipe, side by side, off"},
      {"M", "measure: two points a length, three an angle"},
      {"K",
       "pick the place under the mouse, on bone or face; beside the patient: where the tool touches. \"Bones\" saws, "
       "moves, plates and joins by what was picked"},
      {"C", "the skull beside a normal one, beside its mirror image, alone"},
      {"W", "triangles"},
      {"S", "quality: by frame time, half size, fast, fine skin, shadows, occlusion"},
      {"A", "stereo: side by side, red-cyan, off"},
      {"P", "picture into a file"},
      {"R", "keep the recording of this session, or do not"},
      {"Home", "the first view again"},
      {"? or F1", "this list"}};
  return keys;
}

void Desk::key(int32_t code, uint32_t mods) {
  DeskState& s = state;
  const auto turn_on = [](auto value, int n) { return decltype(value)((int(value) + 1) % n); };
  if (mods & WindowEvent::control) {
    if (code == 'Z') (mods & WindowEvent::shift ? s.redo : s.undo) = true;
    if (code == 'Y') s.redo = true;
    return;
  }
  switch (code) {
    case '1':
    case WindowEvent::escape:
      if (code == WindowEvent::escape && s.help)
        s.help = false;
      else
        choose(Tool::none), s.ruler = false;
      break;
    case '2':
      choose(Tool::scalpel);
      break;
    case '3':
      choose(Tool::undermine);
      break;
    case '4':
      choose(Tool::excise);
      break;
    case '5':
      choose(Tool::hook);
      break;
    case '6':
      choose(Tool::suture);
      break;
    case '7':
      choose(Tool::suture_row);
      break;
    case '8':
      choose(Tool::saw);
      break;
    case '9':
      choose(Tool::grab);
      break;
    case 'F':
      s.face = (s.face + 1) % 3;
      break;
    case 'N':
      s.next = true;
      break;
    case 'T':
      choose_field(s.field == SkinField::none ? first_field() : SkinField::none);
      break;
    case 'V':
      if (!facts_.skin)
        choose_field(s.field == SkinField::none ? SkinField::moved : SkinField::none);
      else
        choose_field(SkinField((int(s.field) + (mods & WindowEvent::shift ? kSkinFields - 1 : 1)) % kSkinFields));
      break;
    case 'I':
      s.iso_lines = !s.iso_lines;
      break;
    case 'L':
      s.tension_lines = !s.tension_lines;
      break;
    case 'X':
      s.lattice = !s.lattice;
      break;
    case 'D':
      s.directions = !s.directions;
      break;
    case 'B':
      s.compare = turn_on(s.compare, 3);
      break;
    case 'M':
      s.ruler = !s.ruler;
      if (s.ruler) choose(Tool::none);
      break;
    case 'K':
      s.head.pick = facts_.head;
      break;
    case 'C':
      if (facts_.head) s.head.beside = turn_on(s.head.beside, 3);
      break;
    case 'W':
      s.wireframe = !s.wireframe;
      break;
    case 'S':
      s.quality = (s.quality + 1) % (1 + kLiveLevels);
      break;
    case 'A':
      s.stereo = turn_on(s.stereo, 3);
      break;
    case 'P':
      s.picture = true;
      break;
    case 'R':
      s.keep_recording = facts_.recording.empty() && !s.keep_recording;
      break;
    case WindowEvent::home:
      s.home = true;
      break;
    case WindowEvent::question:
    case WindowEvent::f1:
      s.help = !s.help;
      break;
    default:
      break;
  }
}

}  // namespace limberg
