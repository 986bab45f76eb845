// Writes the shipped operation scripts into a folder: `ninja -C build write_scripts` renews recordings/*.jsonl.
#include <cstdio>
#include <fstream>

#include "sim/commands/flaps.h"

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: limberg_write_scripts FOLDER\n"), 2;
  for (const char* name : {"rhomboid", "zplasty"}) {
    const std::string path = std::string(argv[1]) + "/" + name + ".jsonl";
    std::ofstream out(path, std::ios::binary);
    out << limberg::to_text(limberg::shipped_script(name));
    if (!out.flush()) return std::fprintf(stderr, "limberg: %s: cannot be written\n", path.c_str()), 2;
  }
}
