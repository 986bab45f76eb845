#include "render/gl_functions.h"

#include <string>

namespace limberg {

GlFunctions::GlFunctions(const GlContext& context) {
#define X(type, name)                                         \
  name = reinterpret_cast<type>(context.address("gl" #name)); \
  if (!name) throw RenderUnavailable(std::string("the graphics driver lacks gl" #name "; expected OpenGL 3.3 core"));
  LIMBERG_GL_FUNCTIONS(X)
#undef X
}

}  // namespace limberg
