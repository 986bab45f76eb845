# Run at every build: writes version.cpp when the commit changed, and only then.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --match=none
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR commit STREQUAL "")
  set(commit unknown)
endif()
set(text "#include \"app/program/version.h\"

namespace limberg {
const char* version() { return \"${VERSION}\"; }
const char* commit() { return \"${commit}\"; }
std::string program_name() { return std::string(\"limberg \") + version() + \" (\" + commit() + \")\"; }
}  // namespace limberg
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
