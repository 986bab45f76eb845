#pragma once
// The OpenGL 3.3 core functions that the renderer uses, as one table filled from a context. Nothing is linked: libGL,
// libOSMesa and libEGL may all be loaded, and each context brings its own functions.
#include <GL/glcorearb.h>

#include "render/gl_context.h"

namespace limberg {

// clang-format off
#define LIMBERG_GL_FUNCTIONS(X) \
  X(PFNGLACTIVETEXTUREPROC, ActiveTexture) X(PFNGLATTACHSHADERPROC, AttachShader) \
  X(PFNGLBINDBUFFERPROC, BindBuffer) X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer) \
  X(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer) X(PFNGLBINDTEXTUREPROC, BindTexture) \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray) X(PFNGLBUFFERDATAPROC, BufferData) \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus) X(PFNGLCLEARPROC, Clear) \
  X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv) X(PFNGLCLEARBUFFERUIVPROC, ClearBufferuiv) \
  X(PFNGLCOMPILESHADERPROC, CompileShader) X(PFNGLCREATEPROGRAMPROC, CreateProgram) \
  X(PFNGLCREATESHADERPROC, CreateShader) X(PFNGLDELETEBUFFERSPROC, DeleteBuffers) \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers) X(PFNGLDELETEPROGRAMPROC, DeleteProgram) \
  X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers) X(PFNGLDELETESHADERPROC, DeleteShader) \
  X(PFNGLDELETETEXTURESPROC, DeleteTextures) X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays) \
  X(PFNGLDEPTHMASKPROC, DepthMask) X(PFNGLDISABLEPROC, Disable) \
  X(PFNGLDRAWARRAYSPROC, DrawArrays) X(PFNGLDRAWELEMENTSPROC, DrawElements) \
  X(PFNGLENABLEPROC, Enable) X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray) \
  X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer) X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D) \
  X(PFNGLGENBUFFERSPROC, GenBuffers) X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers) \
  X(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers) X(PFNGLGENTEXTURESPROC, GenTextures) \
  X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays) X(PFNGLGENERATEMIPMAPPROC, GenerateMipmap) \
  X(PFNGLGETERRORPROC, GetError) X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog) \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv) X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog) \
  X(PFNGLGETSHADERIVPROC, GetShaderiv) X(PFNGLGETSTRINGPROC, GetString) \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation) X(PFNGLLINKPROGRAMPROC, LinkProgram) \
  X(PFNGLPIXELSTOREIPROC, PixelStorei) X(PFNGLPOLYGONOFFSETPROC, PolygonOffset) \
  X(PFNGLREADBUFFERPROC, ReadBuffer) X(PFNGLDRAWBUFFERPROC, DrawBuffer) \
  X(PFNGLREADPIXELSPROC, ReadPixels) X(PFNGLRENDERBUFFERSTORAGEPROC, RenderbufferStorage) \
  X(PFNGLSHADERSOURCEPROC, ShaderSource) X(PFNGLTEXIMAGE2DPROC, TexImage2D) \
  X(PFNGLTEXPARAMETERIPROC, TexParameteri) X(PFNGLTEXPARAMETERFPROC, TexParameterf) \
  X(PFNGLUNIFORM1FPROC, Uniform1f) X(PFNGLUNIFORM1IPROC, Uniform1i) X(PFNGLUNIFORM1UIPROC, Uniform1ui) \
  X(PFNGLUNIFORM2FPROC, Uniform2f) X(PFNGLUNIFORM3FPROC, Uniform3f) \
  X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv) X(PFNGLUSEPROGRAMPROC, UseProgram) \
  X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer) X(PFNGLVERTEXATTRIBIPOINTERPROC, VertexAttribIPointer) \
  X(PFNGLVIEWPORTPROC, Viewport) X(PFNGLGETINTEGERVPROC, GetIntegerv) X(PFNGLGETSTRINGIPROC, GetStringi)
// clang-format on

struct GlFunctions {
#define X(type, name) type name = nullptr;
  LIMBERG_GL_FUNCTIONS(X)
#undef X

  /// RenderUnavailable names the first function that the context lacks. The context must be current.
  explicit GlFunctions(const GlContext& context);
};

}  // namespace limberg
