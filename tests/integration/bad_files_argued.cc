#include "tests/integration/bad_files_argued.h"

#include <vector>

namespace halfshade {
namespace {

// Where most of them come from: the files of Khronos' validator.
const std::string kBase = "validator/base/data/", kExtensions = "validator/ext/";

struct Argued {
  Argument argument;
  std::vector<std::string> files;
};

const std::vector<Argued> kArgued = {
    {{"is accepted", "an empty array of meshes: exporters write them, the picture is right, and a warning says so"},
     {"sharpgltf/SpecialCases/Invalid_EmptyArray.gltf"}},
    {{"is accepted", "contents of an extension that is named as not supported: they cannot make the picture wrong"},
     {kExtensions + "KHR_materials_variants/data/primitive/unresolved_references.gltf"}},
    {{"is accepted without a word", "a change of what is not there is not read"},
     {kBase + "mesh/morph_attribute_no_base.gltf"}},
    {{"is accepted without a word", "a mesh without joints stands as it is, and a warning says so of the mesh"},
     {kBase + "node/node_skin_without_skinned_mesh.gltf"}},
    {{"is accepted without a word", "a scene of nothing, as if it had no nodes"},
     {kBase + "scene/empty_nodes_array.gltf"}},
    {{"is accepted without a word", "a stride of any size reads inside its bufferView, which is checked"},
     {kBase + "buffer_view/invalid_stride_too_big.gltf"}},
    {{"is accepted without a word", "a suggestion: a light that means nothing is not suggested"},
     {kExtensions + "KHR_lights_punctual/data/light/empty_lights_array.gltf",
      kExtensions + "KHR_lights_punctual/data/light/spot_invalid_angles.gltf",
      kExtensions + "KHR_lights_punctual/data/light/spot_light_without_spot_object.gltf"}},
    {{"is accepted without a word", "an attribute of an unknown name is not read"},
     {kBase + "mesh/invalid_attribute.gltf", kBase + "mesh/invalid_attribute_escaped_name.gltf",
      kBase + "mesh/invalid_indexed_attribute.gltf"}},
    {{"is accepted without a word", "an extension that nothing declares is ignored"},
     {kBase + "root/extensions_non_objects.gltf", kBase + "root/extensions_undeclared_wrong_pointer.gltf"}},
    {{"is accepted without a word", "an extension where it means nothing is ignored"},
     {kExtensions + "EXT_texture_webp/data/texture/unexpected_extension.gltf",
      kExtensions + "KHR_materials_anisotropy/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_clearcoat/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_dispersion/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_emissive_strength/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_ior/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_iridescence/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_pbrSpecularGlossiness/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_sheen/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_specular/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_transmission/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_unlit/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_materials_volume/data/material/unexpected_extension.gltf",
      kExtensions + "KHR_texture_transform/data/textureInfo/unexpected_extension.gltf"}},
    {{"is accepted without a word", "any finite matrix can be drawn"},
     {"made/node_matrix_singular.gltf", kBase + "node/matrix_indecomposable.gltf"}},
    {{"is accepted without a word", "bounds are measured: the file's min and max are never used"},
     {kBase + "accessor_data/out_of_range_elements_sint8.gltf",
      kBase + "accessor_data/out_of_range_elements_uint16.gltf",
      kBase + "accessor_data/out_of_range_elements_uint32.gltf", kBase + "animation/sampler_input_no_bounds.gltf"}},
    {{"is accepted without a word",
      "contents of an extension that is named as not supported, or has no effect on shadows"},
     {kExtensions + "EXT_texture_webp/data/texture/unresolved_source.gltf",
      kExtensions + "KHR_animation_pointer/data/animation/channel/target/invalid_pointer_syntax.gltf",
      kExtensions + "KHR_materials_anisotropy/data/material/out_of_range.gltf",
      kExtensions + "KHR_materials_dispersion/data/material/out_of_range.gltf",
      kExtensions + "KHR_materials_ior/data/material/out_of_range.gltf",
      kExtensions + "KHR_materials_specular/data/material/out_of_range.gltf",
      kExtensions + "KHR_materials_volume/data/material/out_of_range.gltf"}},
    {{"is accepted without a word",
      "contents of an extension that is named as not supported: they cannot make the picture wrong"},
     {kExtensions + "KHR_materials_variants/data/primitive/dependency.gltf",
      kExtensions + "KHR_materials_variants/data/primitive/non_unique.gltf",
      kExtensions + "KHR_materials_variants/data/variant/empty_array.gltf",
      kExtensions + "KHR_materials_variants/data/variant/empty_object.gltf"}},
    {{"is accepted without a word", "coordinates of a texture that no image stands behind"},
     {kBase + "mesh/uv.gltf", kExtensions + "KHR_texture_transform/data/textureInfo/uv_sets.gltf"}},
    {{"is accepted without a word", "each primitive has its own targets; weights beyond them move nothing"},
     {kBase + "mesh/morph_unequal_targets_count.gltf"}},
    {{"is accepted without a word", "floats are read as floats, normalized or not"},
     {kBase + "accessor/float_normalized.gltf"}},
    {{"is accepted without a word",
      "its texels are whole; a checksum or a text beside them changes no shadow, and the text is not inflated"},
     {"img_libpng_crashers/badadler.png", "img_libpng_crashers/badadler.png_mask.glb", "img_libpng_crashers/badcrc.png",
      "img_libpng_crashers/badcrc.png_mask.glb", "made/img_png_crc.png", "made/img_png_crc_mask.glb",
      "made/img_png_itxt_bomb.png", "made/img_png_itxt_bomb_mask.glb"}},
    {{"is accepted without a word", "its texels decode; the metadata that are broken are not read"},
     {"img_jpegturbo_bugs/LJPGT-PT-23-01_test1-8.jpg", "img_jpegturbo_bugs/LJPGT-PT-23-01_test1-8.jpg_mask.glb",
      "img_jpegturbo_bugs/mozilla_891693_CVE-2013-6629_CVE-2013-6630_kitty2.jpg",
      "img_jpegturbo_bugs/mozilla_891693_CVE-2013-6629_CVE-2013-6630_kitty2.jpg_mask.glb",
      "img_oiio/jpeg-corrupt/src/corrupt-exif-1626.jpg", "img_oiio/jpeg-corrupt/src/corrupt-exif-1626.jpg_mask.glb",
      "img_oiio/jpeg-corrupt/src/corrupt-exif-deep-ifds.jpg",
      "img_oiio/jpeg-corrupt/src/corrupt-exif-deep-ifds.jpg_mask.glb",
      "img_oiio/jpeg-corrupt/src/corrupt-exif-utf8-type.jpg",
      "img_oiio/jpeg-corrupt/src/corrupt-exif-utf8-type.jpg_mask.glb", "img_oiio/png-damaged/src/exif-utf8-type.png",
      "img_oiio/png-damaged/src/exif-utf8-type.png_mask.glb", "img_oiio/png-damaged/src/xmp-deep-nesting.png",
      "img_oiio/png-damaged/src/xmp-deep-nesting.png_mask.glb", "img_oiio/png-damaged/src/xmp-many-attribs.png",
      "img_oiio/png-damaged/src/xmp-many-attribs.png_mask.glb", "img_oiio/png-damaged/src/xmp-multi-packet.png",
      "img_oiio/png-damaged/src/xmp-multi-packet.png_mask.glb"}},
    {{"is accepted without a word", "joints without weights hold nothing"}, {kBase + "mesh/unequal_joints.gltf"}},
    {{"is accepted without a word", "kept to float precision around its own origin"}, {"made/pos_far_1e7.gltf"}},
    {{"is accepted without a word", "left out with a warning that names the channel, not its sampler"},
     {kBase + "animation/sampler_output_count_invalid.gltf"}},
    {{"is accepted without a word", "left out with a warning that names the channel, not its target"},
     {kBase + "animation/channel_node_matrix.gltf", kBase + "animation/channel_node_no_morphs.gltf"}},
    {{"is accepted without a word", "no stack depends on it, and it loads within its limits"},
     {"made/many_nodes_200000.gltf", "made/node_deep_100000.gltf"}},
    {{"is accepted without a word", "normals are made unit when they are read, signs of tangents likewise"},
     {kBase + "mesh_data/normals_tangents_non_unit_invalid_sign.gltf"}},
    {{"is accepted without a word", "one key is a constant"}, {kBase + "animation/sampler_too_few_cubic_frames.gltf"}},
    {{"is accepted without a word", "rotations are normalized when they are used"},
     {kBase + "animation_data/quaternion_cubic_non_unit_values.gltf",
      kBase + "animation_data/quaternion_non_unit_values.gltf"}},
    {{"is accepted without a word", "said twice"}, {kBase + "root/duplicate_extension_entry.gltf"}},
    {{"is accepted without a word", "the extension is one that we have"}, {"made/ext_required_not_used.gltf"}},
    {{"is accepted without a word", "the index is out of range or unused; read as an index it is checked"},
     {kBase + "mesh_data/index_buffer_primitive_restart.gltf"}},
    {{"is accepted without a word", "the last one holds, as in a channel list read in order"},
     {kBase + "animation/channel_duplicate_targets.gltf"}},
    {{"is accepted without a word", "the type of a data URI changes no byte"},
     {kBase + "buffer/invalid_uri_data_mime.gltf"}},
    {{"is accepted without a word", "the type says which of the two it is"}, {kBase + "camera/extra_type.gltf"}},
    {{"is refused without its name",
      "1e309 is no number of JSON that can be held: found by the parser, which has no place"},
     {kBase + "node/infinite_transform.gltf"}},
    {{"is refused without its name", "another fault is found first: a control character"}, {"made/json_badutf8.gltf"}},
    {{"is refused without its name", "another fault is found first: a cutoff of -5"}, {"made/mat_texcoord9.gltf"}},
    {{"is refused without its name", "another fault is found first: the buffer has no bytes"},
     {kBase + "animation/sampler_bufferview_bytestride.gltf", kBase + "mesh/bufferview_target_override.gltf",
      kBase + "mesh/morph_bufferview_target_override.gltf"}},
    {{"is refused without its name", "no bytes are no bufferView either, and that is what the message names"},
     {"made/img_empty.png", "made/img_empty_mask.glb"}},
    {{"is refused without its name", "the fault is said of the sampler's output, which the channel names"},
     {kBase + "animation/sampler_output_format_invalid.gltf"}},
};

}  // namespace

std::map<std::string, Argument> Arguments() {
  std::map<std::string, Argument> arguments;
  for (const Argued& argued : kArgued) {
    for (const std::string& file : argued.files) arguments[file] = argued.argument;
  }
  return arguments;
}

}  // namespace halfshade
