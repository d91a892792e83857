// Other names for the uniforms and functions of render_volume.glsl, which follows.
#define EMISSION_NAMES
#define nodes emission_nodes
#define bricks emission_bricks
#define atlas emission_atlas
#define transfer emission_transfer
#define first_node emission_first_node
#define atlas_slots emission_atlas_slots
#define first_cell emission_first_cell
#define last_cell emission_last_cell
#define box_min emission_box_min
#define box_max emission_box_max
#define volume_eye emission_eye
#define index_of_view emission_index_of_view
#define find_brick emission_find_brick
#define entry_at emission_entry_at
#define depths_in_box emission_depths_in_box
#define slab_beyond emission_slab_beyond
