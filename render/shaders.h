#pragma once
// The GLSL programs (version 330 core). Skin, walls and sides have a program each: a software rasteriser pays for every
// line of a shader, taken or not. A fragment program of tissue or props is, in this order:
//
//   #version, #define SHADOW / FINE / PART_WALL as wanted, lighting, tissue_common (not for props), its own main
namespace limberg::shaders {

// Vertex attributes of the tissue: 0 position, 1 normal, 2 field (per snapshot); 3 rest position and depth, 4 chart and
// distance to the nearest cut edge (per topology). Of props: 0 position, 1 normal, 2 colour and metal, 3 id.
extern const char* const tissue_vertex;
extern const char* const lighting;
extern const char* const tissue_common;
extern const char* const skin_fragment;
extern const char* const wall_fragment;
extern const char* const side_fragment;
extern const char* const bone_fragment;
extern const char* const face_fragment;
extern const char* const field_fragment;
extern const char* const prop_vertex;
extern const char* const prop_fragment;
extern const char* const background_vertex;
extern const char* const background_fragment;
extern const char* const anaglyph_fragment;  // after #version; with background_vertex
extern const char* const line_vertex;
extern const char* const line_fragment;
extern const char* const depth_vertex;
extern const char* const depth_fragment;
extern const char* const id_vertex;
extern const char* const id_fragment;

}  // namespace limberg::shaders
