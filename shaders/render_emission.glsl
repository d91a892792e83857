// The parts of a ray through a volume and its emission. Follows the second render_volume.glsl.
#undef nodes
#undef bricks
#undef atlas
#undef transfer
#undef first_node
#undef atlas_slots
#undef first_cell
#undef last_cell
#undef box_min
#undef box_max
#undef volume_eye
#undef index_of_view
#undef find_brick
#undef entry_at
#undef depths_in_box
#undef slab_beyond

// Depths where the ray enters and leaves the box of the volume and that of the emission; y <= x: nowhere.
dvec2 volume_depths = dvec2(0.0lf);
dvec2 emission_depths = dvec2(0.0lf);

bool is_in(dvec2 depths, dvec2 part) { return depths.y > depths.x && depths.x <= part.x && part.y <= depths.y; }

// Returns part 0, 1 or 2 of the ray, cut at these depths; y <= x if there is no such part.
dvec2 part_at(int number) {
  if (emission_depths.y <= emission_depths.x) return number == 0 ? volume_depths : dvec2(0.0lf);
  if (volume_depths.y <= volume_depths.x) return number == 0 ? emission_depths : dvec2(0.0lf);
  double a = max(volume_depths.x, emission_depths.x);
  double b = min(volume_depths.y, emission_depths.y);
  if (number == 0) return dvec2(min(volume_depths.x, emission_depths.x), min(a, b));
  if (number == 1) return dvec2(min(a, b), max(a, b));
  return dvec2(max(a, b), max(volume_depths.y, emission_depths.y));
}

int slabs_in(dvec2 part, double depth_step) {
  if (part.y <= part.x || !(is_in(volume_depths, part) || is_in(emission_depths, part))) return 0;
  return int(ceil((part.y - part.x) / depth_step));
}
