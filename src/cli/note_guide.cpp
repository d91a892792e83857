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
    NoteGuide{box_ignored,
              "The file states a periodic box of the simulation that the reader does not use: it is not valid, or the "
              "chosen columns are not x, y and z in this order.",
              "Correct the box in the file, or choose the columns x, y and z in this order with --columns."},
    NoteGuide{data_left_out,
              "The input has data that the program does not use, such as lines and points of a mesh, or that the "
              "output cannot store, such as materials, names of meshes or words of particles.",
              ""},
    NoteGuide{decimal_commas,
              "The table writes decimals with commas, so the reader does not take commas as separators.",
              "Check the number of particles; if it is wrong, write decimals with points."},
    NoteGuide{element_radii,
              "The file has no elements, so --radii takes them from the names of the atoms. Or the file states no "
              "known unit of length, so --radii assumes angstrom.",
              "Write a column element into the file. Give the file's unit with --unit."},
    NoteGuide{extra_bytes, "The file is longer than its header says; the reader ignores the rest.",
              "Check the sizes and types in the header; if they are right, the file may be damaged."},
    NoteGuide{format_not_by_name, "The content or --format says another format than the name of the file.",
              "Rename the file, or choose the format with --input-format or --format."},
    NoteGuide{
        frame_order,
        "The names of the files allow several orders or choices of frames; the note says which one the program uses.",
        "Check the frames with --dry-run; number the files with whole numbers of equal length."},
    NoteGuide{grid_chosen, "The file has several grids; the reader takes the only one with scalar values.",
              "To use another grid, give --grid NAME."},
    NoteGuide{incomplete_frame, "The file ends within its last frame: the simulation is still running, or ended early.",
              "When the simulation has written more, run again, a conversion of all frames with --resume. If no line "
              "is missing, end the last line with a line end."},
    NoteGuide{missing_frames, "Frames of the sequence have no input, or failed.",
              "Add the missing files, or correct the frames that failed. In a conversion, --missing error makes "
              "missing frames an error."},
    NoteGuide{newer_version, "The file has a newer version than the reader knows.",
              "Compare the result with that of the program that wrote the file."},
    NoteGuide{
        other_files,
        "The program takes one kind of files in a folder: volumes, else particles, else pictures, else meshes. It "
        "skips all other files. Or a part of an earlier, longer animation still lies beside the new one.",
        "Instead of the folder give the files, or a pattern such as 'frames/a_####.vdb'. Delete the part of the "
        "earlier animation."},
    NoteGuide{placement_assumed, "The file does not say where its samples are; the note says what the reader assumes.",
              "Give --spacing and --origin, for the file of an attribute --attribute "
              "NAME=FILE:spacing=SX,SY,SZ:origin=X,Y,Z."},
    NoteGuide{
        placement_replaced,
        "--spacing replaces axes of the file that are rotated, sheared or mirrored, or a placement that is not valid.",
        "To keep valid axes of the file, leave --spacing out."},
    NoteGuide{placement_unknown,
              "The program cannot read the record of the placement in a mesh file, or the record did not fit into the "
              "header of a binary stl.",
              "For verify, repeat the placement options of the conversion. For compare and render, write the mesh as "
              "ply or glb."},
    NoteGuide{placement_differs,
              "Two files or frames have different placements. Or a mesh file states its placement, which verify uses.",
              "Use the same placement options for all files. verify needs none for a mesh that states them."},
    NoteGuide{plugin_output,
              "A plug-in, or the library that it uses, reports how it read the file: for example what it assumed, "
              "changed or left out.",
              "Check the result with 'isoextract info'."},
    NoteGuide{staggered_grid,
              "The grid stores the components of vectors on the faces of voxels. The note says where the reader places "
              "them, or that the length of a vector combines components from different positions.",
              "If you need exact lengths of the vectors, interpolate the components to the centers of voxels before "
              "you export the grid."},
    NoteGuide{unclear_positions, "The reader cannot tell which columns hold the positions.",
              "Name them with --columns x=A,y=B,z=C."},
    NoteGuide{value_scale,
              "The header of the NIfTI file has a slope or an intercept that is infinite or NaN. Without a valid slope "
              "the reader uses the values as stored; without a valid intercept it uses 0.",
              "Compare the range of 'isoextract info' with the values that you expect, and correct the header."},
    // Samples and particles
    NoteGuide{attribute_kind,
              "The input does not state the kind of an attribute (scalar, color, vector, point, normal), or the output "
              "is PLY, which cannot mark the integers of an attribute as normalized.",
              "If the kind is missing, give it, for example with --attribute NAME:vector."},
    NoteGuide{attribute_left_out, "The output format cannot store an attribute, or the reader of a mesh skips one.",
              "If the output format is the reason, write a format that stores the attribute, such as ply."},
    NoteGuide{attribute_missing, "An optional attribute is not in the input.", "Leave the attribute out."},
    NoteGuide{attribute_of_nearest,
              "Vertices are too far from all particles to interpolate, so they have the attributes of the nearest one.",
              "Give a larger --radius."},
    NoteGuide{attribute_outside,
              "Vertices are outside the volume of an attribute, so they have the value at its boundary.",
              "Check the placement of the volume of the attribute."},
    NoteGuide{attribute_placement,
              "The volume of an attribute states another placement, world or unit than the input. The note says what "
              "the conversion uses.",
              "Correct the file whose placement is wrong."},
    NoteGuide{attribute_renamed,
              "The format does not allow the attribute's name, or another one has it, so the writer changes it.", ""},
    NoteGuide{cell_size,
              "The samples are closer together than usual, to keep small spheres. Or some spheres are too small for "
              "the given distance, so the surface leaves them out.",
              "Give --cell-size to choose the distance of the samples; the note says which one keeps all spheres."},
    NoteGuide{
        color_range,
        "A first pass over all frames found the range of the colors, so that a value has the same color in all frames.",
        "To choose the range and to save the pass, give --color-by NAME:MIN,MAX."},
    NoteGuide{label_table,
              "A table of label names and colors lies beside the input. The program uses it; if it cannot read the "
              "table, the note says why.",
              "To use another table or none, give --label-names FILE or --label-names none."},
    NoteGuide{labels_assumed, "All samples are whole numbers, so the program takes them as labels.", ""},
    NoteGuide{labels_empty, "The file names labels that no sample has, or masks have no voxels. They have no mesh.",
              ""},
    NoteGuide{labels_lost, "The coarser grid has no sample of some labels.",
              "Give a larger --resolution or a smaller --voxel-size."},
    NoteGuide{labels_small, "Some labels have fewer voxels than --labels-min-voxels, and so no mesh.", ""},
    NoteGuide{labels_unmatched,
              "A range or pattern of --labels matches no label of the file. With --empty skip or write, so does a "
              "number or a name, which is an error otherwise.",
              "'isoextract info' lists the labels."},
    NoteGuide{level_set_interpolated,
              "The program interpolates the level set, so its narrow band stays as wide as that of the input. If the "
              "new voxels are larger, the band has fewer voxels, often too few for other programs.",
              "Give one number to --voxel-size, and no --kernel: the level set gets a band of three voxels. This needs "
              "perpendicular axes."},
    NoteGuide{masks_overlap,
              "Some voxels belong to several masks. Each mask has a closed mesh of all its voxels, so the meshes of "
              "these masks overlap.",
              ""},
    NoteGuide{means_not_possible,
              "The volume is too large for resampling by averages, so isoextract interpolates, which can miss detail.",
              "Give a larger --resolution or a smaller --voxel-size."},
    NoteGuide{nan_attribute, "An attribute is NaN or infinite at some vertices.",
              "Check the volume of the attribute with 'isoextract info'."},
    NoteGuide{nan_samples,
              "A field file keeps NaN samples whatever --nan says. Or render draws nothing around the NaN samples of a "
              "volume.",
              "--nan says how surfaces treat NaN samples: outside, hole or error."},
    NoteGuide{no_data, "Samples with the no-data value become NaN, or no sample has this value.",
              "Check the value of --nodata."},
    NoteGuide{particle_radius,
              "The file or --radii gives each particle a radius; the method takes it, or the median for all. Or all "
              "frames of the sequence have the radius that fits one frame.",
              "Give --radius R to use another radius for all, or --radius auto:each to use a radius of its own for "
              "each frame."},
    NoteGuide{particles_left_out,
              "The surface omits particles whose positions are not finite, or whose radii are too small for the cells.",
              "Repair the positions in the file. For small radii give a smaller --cell-size or a larger --radius."},
    NoteGuide{periodic_box,
              "The file says that the box of the simulation is periodic along some axes. Along these, particles near a "
              "face also count at the opposite face, and the mesh ends at both faces.",
              "Give --periodic none to treat the particles as they are."},
    NoteGuide{region_at_samples,
              "The surface does not end at the faces of --roi but at samples near them, because of --roi-snap, labels, "
              "voxels or surface nets. Or the axes of the samples are oblique to --roi: the program then extracts all "
              "samples that cover it, and clips the surface at its faces.",
              "To end the surface exactly at the faces, leave --roi-snap out. Labels, voxels and surface nets need "
              "--clip for that."},
    NoteGuide{
        samples_in_file,
        "The samples take more than half of the memory limit, or memory is short, and the program cannot map their "
        "file. So it put them into a temporary file, which has no name. The system frees it when the program ends.",
        "Raise --memory-limit, or set the environment variable TMPDIR to a folder on a fast disk."},
    NoteGuide{
        samples_in_windows,
        "The system limits the address space of the process (ulimit -v, in a batch job often its limit of virtual "
        "memory), and the file takes more than half of the free part of it. So the program maps only the layers of "
        "samples that it works on. The mesh is the same.",
        "To map the whole file, raise that limit: ulimit -v unlimited."},
    NoteGuide{sparse_made_dense, "Resampling turns sparse samples into dense ones, which take more memory.",
              "Give a smaller --resolution or a larger --voxel-size."},
    NoteGuide{voxel_size,
              "The sides of the data box are not multiples of the voxel size; the note says which size the grid has.",
              "If the size has to be exact, give one that divides the sides."},
    NoteGuide{voxels_in_files,
              "The voxels of labels and the points of their nets take much of the memory limit. So the program put "
              "them into "
              "temporary files, which have no names. The system frees them when the program ends.",
              "Raise --memory-limit, or set the environment variable TMPDIR to a folder on a fast disk."},
    // Surfaces
    NoteGuide{backend,
              "The note says whether the CPU or the GPU does the work, and why. 'isoextract stability' says which "
              "backend or method it does not test.",
              "'isoextract devices' lists the GPUs, and says why one is not usable."},
    NoteGuide{cap_overlaps, "Cap triangles overlap where the surface touches or crosses itself at a clip plane.",
              "Move the plane of --clip or the face of --roi a little. For a mesh file, add --repair."},
    NoteGuide{clipped,
              "The note gives the number of triangles before and after clipping, of those that clip planes or faces of "
              "--roi cut, and of those that close the cuts. Or clipping cut nothing off.",
              ""},
    NoteGuide{corners_joined,
              "The reader or --repair merges vertices at one position although their attributes differ, and keeps the "
              "attributes of one of them.",
              ""},
    NoteGuide{error_not_measured, "The program cannot measure the error of meshes of labels.", "Leave --error out."},
    NoteGuide{faces_not_merged,
              "Smoothing needs the separate faces of voxels, so the program does not merge them into larger faces.",
              ""},
    NoteGuide{iso_chosen,
              "The program determines the iso value or the labels itself; the note says how. Or each frame has an iso "
              "value of its own, so the surface may jump between frames.",
              "Give a number to --iso, the same for all frames, or choose labels with --labels."},
    NoteGuide{iso_of_labels,
              "The samples look like labels or a binary mask. Their numbers are names, not amounts, so an iso value or "
              "a transfer function between them means nothing.",
              "For labels give --labels all, for a mask --method surface-nets; see 'isoextract help labels' and "
              "'isoextract help masks'."},
    NoteGuide{labels_part,
              "The edit changes the mesh of each label on its own, so neighbors no longer share their boundary.",
              "Leave --smooth out, and raise --relax with --method surface-nets: it moves shared vertices together."},
    NoteGuide{many_components, "Each component keeps a few triangles, so many components limit the simplification.",
              "Remove small components with --drop-components MIN."},
    NoteGuide{moved_apart,
              "Sheets of the surface touch, and programs that weld vertices by position would join them, so the "
              "program moves them apart.",
              "Give --touching keep for exact positions, or write ply, obj or glb."},
    NoteGuide{no_surface,
              "An iso value, a label, a mesh or a frame has no surface or no volume, so the output lacks it. The note "
              "says which.",
              "'isoextract info' shows the range of the samples."},
    NoteGuide{open_components_kept, "Open components have no volume, so a filter by volume keeps them.",
              "Close them: with --cap at the data boundary and at cuts, with --repair in a mesh file."},
    NoteGuide{open_mesh, "The mesh is open where a clip plane or a face of --roi cuts it.", "Close it with --cap."},
    NoteGuide{repeated_iso, "Two iso values are equal, so the file has one surface for both.", "Give each value once."},
    NoteGuide{
        simplified_in_windows,
        "The memory limit does not allow to simplify the whole mesh at once, so the program simplified windows of "
        "it, one after the other. The distance is proven as always, but other limits give other triangles.",
        "Set --memory-limit for the same triangles on each machine."},
    NoteGuide{simplified_shells, "Simplification turned thin shells inside out, or moved cavities out of their body.",
              "Give a smaller --simplify or a larger --triangles, or remove the components with --drop-components and "
              "the cavities with --fill-cavities."},
    NoteGuide{volume_changed, "Relaxing could not keep the volume of a label or component within 0.1 %.",
              "--relax 0 keeps the volumes of the voxels."},
    NoteGuide{zero_area, "Smoothing moved the corners of triangles onto one line, mostly in thin parts that it shrank.",
              "Give --smooth fewer passes. Of a mesh file, --repair removes such triangles: isoextract MESH --repair "
              "-o OUT."},
    // Output
    NoteGuide{animation_kept, "No frame needs a conversion, so the animation stays unchanged.",
              "To write it again, leave --resume or --no-clobber out."},
    NoteGuide{animation_times,
              "The file states the times of its frames, and they are not evenly spaced; the animation shows each frame "
              "at its time.",
              ""},
    NoteGuide{empty_picture, "The camera sees nothing.",
              "Change --camera or --look-at, or in render the transfer function (--tf)."},
    NoteGuide{flat_normals,
              "glTF stores flat normals with three vertices for each triangle, so the file has no welded vertices.",
              "Give --normals none: viewers then shade flat as well."},
    NoteGuide{frames_kept, "Some frames of the simulation exist already; the program does not overwrite them.",
              "To write them again, delete them or leave --no-clobber out."},
    NoteGuide{frames_move,
              "--center moves each frame by its own center, so frames of particles or of sparse volumes shift against "
              "each other.",
              "Give --roi: its center is the same for all frames."},
    NoteGuide{length_unit,
              "The coordinates of a glTF file are not in meters, the unit that glTF prescribes. Or the frames have "
              "different units.",
              "Leave --to-unit out, and give --unit file, or --unit mm if the file states no unit: glTF is then in "
              "meters. For one unit in all frames give --unit file --to-unit mm."},
    NoteGuide{memory_unknown, "The program cannot estimate the memory of a frame.", ""},
    NoteGuide{no_effect, "An option has no effect on this input or output.", "Leave the option out."},
    NoteGuide{no_plot, "bench draws no plot, because it measured no error.", ""},
    NoteGuide{not_coarsened,
              "The grid has too few samples for one of the default factors of --coarser, so bench skips this factor.",
              ""},
    NoteGuide{not_verified, "Verification compares positions and triangles, not attributes and colors.", ""},
    NoteGuide{old_pieces, "The program removed or renamed files of an earlier run.", ""},
    NoteGuide{one_camera,
              "The first picture sets the camera of all pictures, or each picture has its own; the note says which.",
              "Give --camera AZ,EL,DISTANCE and --look-at X,Y,Z."},
    NoteGuide{placement_not_stored,
              "The format of the written file cannot store the placement: the spacing and origin of a field, the side "
              "of a level set, or the box and the unit of particles.",
              "When you read the file, give the values in the note: --spacing, --origin, --inside below, --box, "
              "--periodic, --unit. Or write a field as .nrrd or .vti, which store its placement, or as .vdb, which "
              "stores the side as well."},
    NoteGuide{renamed_meshes,
              "The name of a mesh is not UTF-8, which glTF requires, so the writer replaces the invalid bytes.", ""},
    NoteGuide{rounded_positions,
              "The mesh is so far from the origin that the numbers in the file are too coarse for it. In STL they may "
              "move a vertex by a thousandth of an edge or more, or corners of a triangle have become equal.",
              "Move the mesh to the origin with --center or --origin. Or write glb, gltf, ply or obj, which store the "
              "full precision."},
    NoteGuide{several_files, "The animation is larger than a .glb can be, so it is in several files.", ""},
    NoteGuide{shard,
              "The environment has the number of a shard, but the run converts all frames. Or a table, plot or page "
              "covers one shard only. Or mpirun started several processes, and the note says how they share the work "
              "('isoextract help mpi').",
              "To convert one shard, give --shard auto. To get a table, plot or page of all frames, run 'isoextract "
              "merge', then the command with --resume and without --shard."},
    NoteGuide{simulation_limits,
              "The simulation differs from what the options suggest: particles are still in the nozzle, the program "
              "slowed particles that fell too fast, the water does not come to rest, or depths are below 0. Or later "
              "volumes have more layers because the water rises.",
              "For particles in the nozzle simulate more frames. For water that does not come to rest raise --flow-div "
              "or --friction."},
    NoteGuide{up_axis,
              "The program that wrote the file has another up axis than isoextract assumes, or the output has another "
              "one than its format prescribes.",
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
