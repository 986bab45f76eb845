#pragma once
// The GLSL programs (version 330 core). One source string each; shared lighting functions are put in front.
namespace limberg::shaders {

// Vertex attributes of the tissue: 0 position, 1 normal, 2 field (per snapshot); 3 rest position and depth, 4 chart,
// 5 part (per topology). Of props: 0 position, 1 normal, 2 colour and metal, 3 id.
extern const char* const tissue_vertex;
extern const char* const tissue_fragment;
extern const char* const prop_vertex;
extern const char* const prop_fragment;
extern const char* const lighting;  // included by the two fragment programs above
extern const char* const background_vertex;
extern const char* const background_fragment;
extern const char* const depth_vertex;
extern const char* const depth_fragment;
extern const char* const id_vertex;
extern const char* const id_fragment;

}  // namespace limberg::shaders
