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
#ifdef __clang__
std::string compiler() {
  return \"clang \" + std::to_string(__clang_major__) + \".\" + std::to_string(__clang_minor__) + \".\" +
         std::to_string(__clang_patchlevel__);
}
#else
std::string compiler() {
  return \"g++ \" + std::to_string(__GNUC__) + \".\" + std::to_string(__GNUC_MINOR__) + \".\" +
         std::to_string(__GNUC_PATCHLEVEL__);
}
#endif
const char* processor() {
#if defined(__x86_64__)
  return \"x86_64\";
#elif defined(__aarch64__)
  return \"aarch64\";
#else
  return \"another processor\";
#endif
}
}  // namespace limberg
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
