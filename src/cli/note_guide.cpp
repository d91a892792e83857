#include "cli/note_guide.hpp"

#include <array>
#include <cstddef>

namespace isoextract::cli {
namespace {

using enum NoteId;

constexpr std::array kGuide{
    // Input
    NoteGuide{assumed_columns, "The file does not name its columns, so the reader takes the first three as x, y and z.",
              "Name the columns with --columns x=A,y=B,z=C, or add a header line to the file."},
    NoteGuide{axes_dropped, "The array has axes of length 1, which the reader drops.", ""},
    NoteGuide{box_ignored, "The reader cannot use the box of the simulation that the file states.",
              "Correct the box in the file."},
    NoteGuide{data_left_out,
              "The file has data that the program does not use, such as lines and points of a mesh, or text columns of "
              "particles.",
              ""},
    NoteGuide{decimal_commas,
              "The table writes decimals with commas, so the reader does not take commas as separators.",
              "Check the number of particles; if it is wrong, write decimals with points."},
    NoteGuide{element_radii,
              "The file has no elements, so --radii takes them from the names of the atoms. Or the file states no unit "
              "of length, so --radii takes it to be angstrom.",
              "Write a column element into the file. Give the file's unit with --unit."},
    NoteGuide{extra_bytes, "The file is longer than its header says; the reader ignores the rest.",
              "Check --dims, --dtype and --skip for raw files. Otherwise the file may be damaged."},
    NoteGuide{format_not_by_name, "The content or --format says another format than the name of the file.",
              "Rename the file, or choose the format with --input-format or --format."},
    NoteGuide{frame_order, "The names of the frames allow several orders; the note says which one the program uses.",
              "Check the order with --dry-run; number the files with whole numbers of equal length."},
    NoteGuide{grid_chosen, "The file has several grids; the reader takes the only one with scalar values.",
              "To use another grid, give --grid NAME."},
    NoteGuide{incomplete_frame, "The file ends within its last frame: the simulation is still running, or ended early.",
              "When the simulation has written more, run again with --resume. If no line is missing, end the last line "
              "with a line end."},
    NoteGuide{missing_frames, "Frames of the sequence have no input, or failed.",
              "Add the missing files. --missing error makes this an error."},
    NoteGuide{newer_version, "The file has a newer version than the reader knows.",
              "Compare the result with that of the program that wrote the file."},
    NoteGuide{other_files, "The folder has other files, which do not belong to the sequence.",
              "Give a pattern instead of the folder, such as 'frames/a_####.vdb'."},
    NoteGuide{placement_assumed, "The file does not say where its samples are; the note says what the reader assumes.",
              "Give --spacing and --origin."},
    NoteGuide{placement_replaced, "The options replace the placement of the file.",
              "Leave --spacing and --origin out to use that of the file."},
    NoteGuide{placement_unknown, "The mesh file has a record of its placement that the program cannot read.",
              "Repeat the placement options of the conversion."},
    NoteGuide{placement_differs, "Two files or frames, or a file and the options, have different placements.",
              "Use the same placement options for all."},
    NoteGuide{plugin_output, "A plug-in printed text or returned a note.", "Ask the author of the plug-in."},
    NoteGuide{staggered_grid,
              "The grid stores the components of vectors on the faces of voxels; the note says where the reader places "
              "them.",
              "If you need exact lengths of the vectors, interpolate the components to the centers of voxels before "
              "you export the grid."},
    NoteGuide{unclear_positions, "The reader cannot tell which columns hold the positions.",
              "Name them with --columns x=A,y=B,z=C."},
    NoteGuide{value_scale,
              "The scale of the values in the header is not a number, so the reader uses values as stored.",
              "Check the iso value with 'isoextract info'."},
    // Samples and particles
    NoteGuide{attribute_kind,
              "The input does not state the kind of an attribute (scalar, color, vector, point, normal), or the output "
              "is PLY, which cannot mark the integers of an attribute as normalized.",
              "If the kind is missing, give it, for example with --attribute NAME:vector."},
    NoteGuide{attribute_left_out, "The output format cannot store an attribute, or the reader of a mesh skips one.",
              "Write a format that stores it, such as ply."},
    NoteGuide{attribute_missing, "An optional attribute is not in the input.", "Leave the attribute out."},
    NoteGuide{attribute_of_nearest,
              "Vertices are too far from all particles to interpolate, so they have the attributes of the nearest one.",
              "Give a larger --radius."},
    NoteGuide{attribute_outside,
              "Vertices are outside the volume of an attribute, so they have the value at its boundary.",
              "Check the placement of the volume of the attribute."},
    NoteGuide{attribute_placement, "The volume of an attribute has another placement than the input.",
              "Check that both volumes are in the same world coordinates."},
    NoteGuide{attribute_renamed,
              "The format does not allow the attribute's name, or another one has it, so the writer changes it.", ""},
    NoteGuide{
        cell_size,
        "The samples are closer together than usual, to keep small spheres. Or some spheres are too small for the "
        "given distance, so the surface leaves them out.",
        "Give --cell-size to choose the distance of the samples; the note says which one keeps all spheres."},
    NoteGuide{color_range,
              "A first pass over all frames found the range of the colors, so that equal colors mean equal values.",
              "Give --color-by NAME:MAP:MIN,MAX to choose the range, and to save the pass."},
    NoteGuide{label_table, "A table of label names and colors lies beside the input.",
              "To use another table or none, give --label-names FILE or --label-names none."},
    NoteGuide{labels_assumed, "All samples are whole numbers, so the program takes them as labels.", ""},
    NoteGuide{labels_empty, "The file names labels that no sample has.", "None: they have no mesh."},
    NoteGuide{labels_lost, "The coarser grid has no sample of some labels.", "Choose a finer grid."},
    NoteGuide{labels_small, "Some labels have fewer voxels than --labels-min-voxels, and so no mesh.", ""},
    NoteGuide{labels_unmatched,
              "A range or pattern of --labels matches no label of the file; with --empty also a number or a name.",
              "'isoextract info' lists the names."},
    NoteGuide{level_set_interpolated,
              "A written level set has interpolated values and the narrow band of the input, which is too narrow for "
              "other programs if its voxels are larger.",
              "Give one number to --voxel-size, and no --kernel: the level set gets a band of three voxels."},
    NoteGuide{masks_overlap, "Some voxels belong to more than one of the masks.",
              "None: each mask has a closed mesh of all its voxels, and meshes of overlapping masks overlap."},
    NoteGuide{means_not_possible,
              "The volume is too large for resampling by averages, so isoextract interpolates, which can miss detail.",
              "Choose a finer --resolution, or resample in several steps."},
    NoteGuide{nan_attribute, "An attribute is NaN or infinite at some vertices.",
              "Check the volume of the attribute with 'isoextract info'."},
    NoteGuide{nan_samples,
              "Some samples are NaN: a field file stores them unchanged, and render draws nothing around them.",
              "Choose with --nan how surfaces treat them: outside, hole or error."},
    NoteGuide{no_data, "Samples with the no-data value become NaN, or no sample has this value.",
              "Check the value of --nodata."},
    NoteGuide{particle_radius,
              "Particles have radii of their own from an attribute, or all frames have the radius that fits one frame.",
              "Give --radius to use another radius for all, or --radius auto:each for one for each frame."},
    NoteGuide{particles_left_out,
              "The surface omits particles whose positions are not finite, or whose radii are too small for the cells.",
              "Repair the positions in the file. For small radii give a smaller --cell-size or a larger --radius."},
    NoteGuide{periodic_box,
              "The file says that the box of the simulation is periodic: particles near a face continue the surface at "
              "the opposite face, and the surface ends at the faces of the box.",
              "Give --periodic none to treat the particles as they are."},
    NoteGuide{region_at_samples,
              "The faces of the region are between samples or oblique to the axes, so the surface ends at samples near "
              "them.",
              "Clip at exact planes with --clip."},
    NoteGuide{sparse_made_dense, "Resampling turns sparse samples into dense ones, which take more memory.",
              "Give a smaller --resolution or a larger --voxel-size."},
    NoteGuide{voxel_size,
              "The sides of the data box are no multiples of the voxel size; the note says which size the grid has.",
              "If the size has to be exact, give one that divides the sides."},
    // Surfaces
    NoteGuide{backend, "The note names the backend that the program chose, or that 'isoextract stability' skips.",
              "'isoextract devices' lists the GPUs and says why one is not usable."},
    NoteGuide{cap_overlaps, "Cap triangles overlap where the surface touches or crosses itself at a clip plane.",
              "Move the plane a little, or repair the mesh."},
    NoteGuide{clipped, "The note tells how many triangles the clip planes removed and cut.", ""},
    NoteGuide{corners_joined,
              "The reader merges triangle corners at one position although their attributes differ, and keeps the "
              "attributes of one of them.",
              ""},
    NoteGuide{error_not_measured, "The program cannot measure the error of this mesh.", "Leave --error out."},
    NoteGuide{faces_not_merged,
              "Smoothing needs the separate faces of voxels, so the program does not merge them into larger faces.",
              ""},
    NoteGuide{iso_chosen, "The program chose the iso value, or the value differs between frames.",
              "Give --iso V, the same for all frames."},
    NoteGuide{iso_of_labels, "The samples look like labels or a mask, which have nothing between their values.",
              "Use --labels all for labels, --method surface-nets for a mask; see 'isoextract help labels'."},
    NoteGuide{labels_part,
              "The edit changes the mesh of each label on its own, so neighbors no longer share their boundary.",
              "Smooth with --relax, which moves shared vertices together."},
    NoteGuide{many_components, "Each component keeps a few triangles, so many components limit the simplification.",
              "Remove small components with --drop-components MIN."},
    NoteGuide{moved_apart, "Sheets of the surface touch, and readers of STL would join them, so they moved apart.",
              "Give --touching keep for exact positions, or write ply, obj or glb."},
    NoteGuide{no_surface, "An iso value or label has no surface, so it has no mesh.",
              "'isoextract info' shows the range of the samples."},
    NoteGuide{open_components_kept, "Open components have no volume, so a filter by volume keeps them.",
              "Close them with --cap."},
    NoteGuide{open_mesh, "The mesh is open where a clip plane or a face of --roi cuts it.", "Close it with --cap."},
    NoteGuide{repeated_iso, "Two iso values are equal, so the file has one surface for both.", "Give each value once."},
    NoteGuide{simplified_shells, "Simplification turned thin shells inside out, or moved cavities out of their body.",
              "Give a smaller distance or more triangles."},
    NoteGuide{volume_changed, "Relaxing could not keep the volume of a label or component within 0.1 %.",
              "--relax 0 keeps the volumes of the voxels."},
    // Output
    NoteGuide{animation_kept, "No frame needs a conversion, so the animation stays unchanged.",
              "To write it again, leave --resume or --no-clobber out."},
    NoteGuide{animation_times,
              "The file states the times of its frames, and they are not evenly spaced; the animation shows each frame "
              "at its time.",
              ""},
    NoteGuide{empty_picture, "The camera sees nothing.", "Change --camera or --look-at, or the transfer function."},
    NoteGuide{flat_normals,
              "glTF stores flat normals with three vertices for each triangle, so the file has no welded vertices.",
              "Give --normals none: viewers then shade flat as well."},
    NoteGuide{frames_kept, "Some frames of the simulation exist already; the program does not overwrite them.",
              "To write them again, delete them or leave --no-clobber out."},
    NoteGuide{frames_move, "--center moves each frame by its own center, so the frames shift against each other.",
              "Give --roi: its center is the same for all frames."},
    NoteGuide{length_unit, "Lengths are in another unit than the format prescribes, or in several units.",
              "Give --unit file, which writes glTF in meters, or --to-unit."},
    NoteGuide{memory_unknown, "The program cannot estimate the memory of a frame.", ""},
    NoteGuide{no_effect, "An option has no effect on this input or output.", "Leave the option out."},
    NoteGuide{no_plot, "There is nothing to plot.", ""},
    NoteGuide{not_coarsened,
              "The grid has too few samples for one of the default factors of --coarser, so bench skips this factor.",
              ""},
    NoteGuide{not_verified, "Verification compares positions and triangles, not attributes and colors.", ""},
    NoteGuide{old_pieces, "The program removed or renamed files of an earlier run.", ""},
    NoteGuide{one_camera,
              "The first picture sets the camera of all pictures, or each picture has its own; the note says which.",
              "Give --camera and --look-at."},
    NoteGuide{
        placement_not_stored,
        "The format of the written file cannot store the placement: the spacing and origin of a field, the side of "
        "a level set, or the box and the unit of particles.",
        "When you read the file, give the values in the note: --spacing, --origin, --inside below, --box, "
        "--periodic, --unit. NRRD stores the placement of a field, and .vdb the side as well."},
    NoteGuide{renamed_meshes,
              "The name of a mesh is not UTF-8, which glTF requires, so the writer replaces the invalid bytes.", ""},
    NoteGuide{
        rounded_positions,
        "So far from the origin the coordinates in the file are coarse: STL rounds them by a thousandth of an edge "
        "or more, or corners of a triangle become equal.",
        "Use --center, move the volume nearer to the origin, or write glb."},
    NoteGuide{several_files, "The animation is larger than a .glb can be, so it is in several files.", ""},
    NoteGuide{shard,
              "The environment has the number of a shard, but the run converts all frames. Or a table, plot or page "
              "covers one shard only. Or mpirun started several processes, and the note says how they share the work "
              "('isoextract help mpi').",
              "To convert one shard, give --shard auto. To get a table, plot or page of all frames, run 'isoextract "
              "merge', then the command with --resume and without --shard."},
    NoteGuide{simulation_limits, "The simulation reached one of its limits; the note says which.",
              "If the note names options or more frames, change these."},
    NoteGuide{up_axis,
              "The program that wrote the file has another up axis than isoextract assumes, or the output has "
              "another one than its format prescribes.",
              "Give the up axis of the input with --up, or leave --up-out out."},
};

constexpr bool is_complete() {
  constexpr auto kWords = words_of(NoteId{});
  constexpr auto kLast = static_cast<std::size_t>(NoteId::up_axis);
  if (kWords.size() != kLast + 1 || kWords.size() != kGuide.size()) return false;
  for (std::size_t i = 0; i < kGuide.size(); ++i) {
    if (kWords[i].value != static_cast<NoteId>(i) || kGuide[i].id != kWords[i].value) return false;
  }
  return true;
}
static_assert(is_complete(), "each id needs a word and an entry, in the order of the ids");

}  // namespace

std::span<const NoteGuide> note_guide() { return kGuide; }

}  // namespace isoextract::cli
