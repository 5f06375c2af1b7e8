// The page's glossary: for each name of the service its label, the kind of its quantity, and its explanation. Fields, figures, charts and tables take their labels and tooltips from here.

/** Names of requests and answers. */
export const NAMES = {
  // Cutter
  type: { label: 'Shape', help: 'Shape of the cutter: toroidal (bull-nose), ball, flat, a ball on a cone, a lens, a barrel with a ball tip, or any profile of arcs.' },
  diameter_mm: { label: 'Diameter', kind: 'length', help: 'Outer diameter of the cutter (ISO 13399: DC).' },
  corner_radius_mm: { label: 'Corner radius', kind: 'length', help: 'Radius of the rounded corner (ISO 13399: RE). Under half the diameter.' },
  taper_deg: { label: 'Taper', kind: 'angle', help: 'Half the angle of the cone: that of its flank to the axis.' },
  shank_diameter_mm: { label: 'Shank diameter', kind: 'length', help: 'Diameter at which the cone ends.' },
  lens_radius_mm: { label: 'Lens radius', kind: 'length', help: 'Radius of the bottom, which is centred on the axis. At least half the diameter.' },
  tip_radius_mm: { label: 'Tip radius', kind: 'length', help: 'Radius of the ball tip.' },
  side_radius_mm: { label: 'Side radius', kind: 'length', help: 'Radius of the side, which touches the tip and ends at the diameter.' },
  arcs: { label: 'Arcs', help: 'One arc a line, from the tip outwards: radius, offset and height of its centre in mm, and the angles of its normal from and to, 0° straight down. Where two do not touch, a flat or a cone joins them.' },
  teeth: { label: 'Teeth', kind: 'count', help: 'Number of effective teeth (ISO 13399: ZEFP), 1 to 100.' },
  spindle_speed_rpm: { label: 'Spindle speed', kind: 'speed', help: 'Revolutions per minute. With the teeth it turns feed per tooth into feed rate.' },
  flute_length_mm: { label: 'Flute length', kind: 'length', help: 'Cutting length of the flutes. The service warns where the surface is deeper.' },
  max_feed_per_tooth_mm: { label: 'Max feed per tooth', kind: 'length', help: 'The cutter maker’s limit on the feed per tooth.' },
  max_feed_rate_mm_min: { label: 'Max feed rate', kind: 'feedRate', help: 'The machine’s limit on the feed rate.' },
  // Contact
  slope_deg: { label: 'Slope', kind: 'angle', help: 'Angle between the surface normal and the tool axis: 0° is a floor, 90° a wall.' },
  feed_angle_deg: { label: 'Feed angle', kind: 'angle', help: 'Angle from the uphill steepest line to the feed, seen from above along the tool axis, counter-clockwise. 0° runs uphill, 90° along the contour.' },
  normal: { label: 'Surface normal', help: 'Vector x, y, z out of the part, of any length.' },
  feed: { label: 'Feed vector', help: 'Vector x, y, z of the feed; only its component in the tangent plane is used.' },
  tool_axis: { label: 'Tool axis', help: 'Vector x, y, z of the tool axis for five-axis milling. Empty: +Z.' },
  surface_radius_mm: { label: 'Surface radius', kind: 'length', help: 'Radius of the surface across the feed: positive where convex, negative where concave.' },
  along_per_mm: { label: 'Along the feed', kind: 'curvature', help: 'Curvature (1/radius) along the feed: positive where convex.' },
  across_per_mm: { label: 'Across the feed', kind: 'curvature', help: 'Curvature (1/radius) across the feed: positive where convex.' },
  twist_per_mm: { label: 'Twist', kind: 'curvature', help: 'Mixed curvature of the surface between the feed and its left.' },
  radial_mm: { label: 'Radial runout', kind: 'height', help: 'Radial runout of the cutter in the spindle.' },
  axial_mm: { label: 'Axial runout', kind: 'height', help: 'Axial runout: the height by which one tooth stands below another.' },
  // Passes
  step_over_mm: { label: 'Step-over', kind: 'length', help: 'Distance between neighbouring passes along the surface, across the feed.' },
  step_over_xy_mm: { label: 'Step-over in XY', kind: 'length', help: 'Distance between the vertical planes of neighbouring passes, seen from above, as CAM systems program it.' },
  min_step_over_mm: { label: 'Min step-over', kind: 'length', help: 'Smallest step-over to consider.' },
  max_step_over_mm: { label: 'Max step-over', kind: 'length', help: 'Largest step-over to consider; also the largest that the tolerance allows without feed.' },
  feed_per_tooth_mm: { label: 'Feed per tooth', kind: 'length', help: 'Advance along the feed for each tooth. 0 or empty: no tooth marks.' },
  feed_rate_mm_min: { label: 'Feed rate', kind: 'feedRate', help: 'Feed per tooth × teeth × spindle speed; of a plan, the mean over its passes.' },
  area_rate_mm2_min: { label: 'Area rate', kind: 'areaRate', help: 'Surface finished per minute: step-over × feed rate.' },
  scallop_tolerance_mm: { label: 'Tolerance', kind: 'height', help: 'Largest scallop height that is accepted, tooth marks included.' },
  // Answers
  scallop_height_mm: { label: 'Scallop height', kind: 'height', help: 'Height of the ridge over the nominal surface, from step-over and feed together.' },
  step_over_height_mm: { label: 'of it step-over', kind: 'height', help: 'Part of the height that the step-over alone leaves between two passes.' },
  feed_height_mm: { label: 'of it feed', kind: 'height', help: 'Part of the height that the tooth marks add.' },
  feed_share: { label: 'Feed’s share', kind: 'share', help: 'The feed’s part of the scallop height.' },
  effective_radius_mm: { label: 'Effective radius', kind: 'length', help: 'Radius of curvature of the groove across the feed.' },
  transverse_effective_radius_mm: { label: 'Transverse radius', kind: 'length', help: 'Transverse effective radius: the same for the direction at 90° seen from above; it governs the tooth marks.' },
  deviation: { label: 'Deviation', kind: 'share', help: '(height − exact height) / exact height: the deviation of this model’s height from the height by the cutter’s exact shape.' },
  ra_um: { label: 'Ra', kind: 'roughness', help: 'Arithmetic mean roughness of the geometry that the height stands for; a real surface is rougher.' },
  allowance: { label: 'Rougher by', kind: 'number', help: 'How much rougher the real surface is than its geometry, by vibration and wear: handbooks say 1.5 to 3.' },
  limited_by: { label: 'Limited by', help: 'The limit that the answer reaches.' },
  // Plan
  tool_changes: { label: 'Tool changes', kind: 'count', help: 'Changes between operations with different tools; each takes the machine’s tool change.' },
  area_share: { label: 'Area', kind: 'share', help: 'Share of the area that the operation machines.' },
  rest_area_share: { label: 'Rest', kind: 'share', help: 'Share of the area that the cutter before could not reach: all figures are over it.' },
  step_down_mm: { label: 'Step down', kind: 'length', help: 'Distance of level lines along Z.' },
  machining_time_s: { label: 'Time', kind: 'time', help: 'Machining time: all passes and links with the machine’s limited acceleration and jerk.' },
  direction_deg: { label: 'Direction', kind: 'angle', help: 'Direction of the passes seen from above, from +X counter-clockwise.' },
  passes: { label: 'Passes', kind: 'count', help: 'Number of passes.' },
  path_length_mm: { label: 'Path length', kind: 'length', help: 'Length of all passes and links.' },
  over_tolerance_share: { label: 'Over tolerance', kind: 'share', help: 'Share of the area that the cutter can reach and the path leaves more than 2 % over the tolerance.' },
  needed_max_uncut_share: { label: 'Needed', kind: 'share', help: 'The least share that a cutter leaves uncut.' },
  smallest_concave_radius_mm: { label: 'Tightest hollow', kind: 'length', help: 'Smallest radius of a hollow of the surface.' },
  uncut_share: { label: 'Uncut', kind: 'share', help: 'Share of the area that the cutter leaves over the tolerance because it does not fit.' },
  uncut_height_mm: { label: 'Uncut height', kind: 'height', help: 'Largest height of the material that the cutter cannot reach.' },
  gouge_mm: { label: 'Gouge', kind: 'height', help: 'Deepest cut of the path into the part, links and lifts included.' },
  used_share: { label: 'Used', kind: 'share', help: 'Share of the area that is left with at least half of the tolerance. On a plane between evenly spaced passes it is 29 %.' },
  least_time_s: { label: 'Least time', kind: 'time', help: 'Lower bound: no passes of this cutter that keep the tolerance are faster. It knows neither stops nor walls.' },
  machine: { label: 'Preset', help: 'A machine by its name. Limits that are stated override its own.' },
  acceleration_m_s2: { label: 'Acceleration', kind: 'acceleration', help: 'The machine’s acceleration along the path.' },
  jerk_m_s3: { label: 'Jerk', kind: 'jerk', help: 'The machine’s jerk: the rate of change of the acceleration.' },
  rapid_rate_mm_min: { label: 'Rapid rate', kind: 'feedRate', help: 'Rate of moves off the surface. Empty: the feed rate.' },
  max_spindle_speed_rpm: { label: 'Max speed', kind: 'speed', help: 'The machine’s largest spindle speed. Cutters that state a higher one run at it.' },
  path_tolerance_mm: { label: 'Path tolerance', kind: 'height', help: 'How far the control may leave the path to round a corner: it looks ahead and need not stop there. Empty: as the method has it.' },
  tool_change_s: { label: 'Tool change', kind: 'time', help: 'Time of a tool change between operations.' },
  time_factor: { label: 'Time factor', kind: 'number', help: 'What a shop measured over what was stated; multiplies every time.' },
  clearance_height_mm: { label: 'Clearance', kind: 'length', help: 'Height over the highest point at which the tool crosses gaps.' },
  pattern: { label: 'Pattern', help: 'Zigzag cuts in both senses; one-way returns at the rapid rate over the clearance height.' },
  method: { label: 'Method', help: 'Surface: the tips’ path is made and milled on the surface itself. Rectangle: the published method on an equivalent inclined rectangle.' },
  model: { label: 'Model', help: 'Exact: the cutter’s whole body. Published: circles of the effective radii.' },
  max_slope_deg: { label: 'Max slope', kind: 'angle', help: 'Steeper facets do not limit the spacing and count as steep.' },
  max_uncut_share: { label: 'Max uncut', kind: 'share', help: 'A cutter that leaves more of the area uncut is listed, not ranked.' },
  directions_deg: { label: 'Directions', help: 'Directions of the passes to try, in degrees from +X counter-clockwise, with commas between them. Empty: all.' },
  unit: { label: 'File’s unit', help: 'Unit of length of the coordinates in the file. A 3MF file states its own.' },
  facing: { label: 'Facing', help: 'The facets of the shape: those that face up, or all.' },
  // Surface
  area_mm2: { label: 'Area', kind: 'area', help: 'Area of the surface.' },
  facets: { label: 'Facets', kind: 'count', help: 'Triangles of the surface.' },
  points: { label: 'Points', kind: 'count', help: 'Points from which the shape was computed; 0 if it was computed from facets.' },
  mean_slope_deg: { label: 'Mean slope', kind: 'angle', help: 'Mean slope over the area.' },
  form_factor: { label: 'Form factor', kind: 'number', help: 'Long side over short side of the equivalent rectangle, which has the same variances.' },
  characteristic_size_mm2: { label: 'Characteristic size', kind: 'area', help: 'Area of the equivalent rectangle.' },
  principal_direction_deg: { label: 'Principal direction', kind: 'angle', help: 'Direction of the longest extent seen from above.' },
  steepest_direction_deg: { label: 'Steepest direction', kind: 'angle', help: 'Direction of the steepest line of the mean plane, seen from above.' },
  flatness: { label: 'Flatness', kind: 'number', help: 'Extent out of the mean plane over the longest extent: 0 for a plane.' },
  visible_area_share: { label: 'Visible area', kind: 'share', help: 'Share of the area that is visible from above.' },
  steep_area_share: { label: 'Steep area', kind: 'share', help: 'Share of the area steeper than the maximal slope.' },
  bounds_mm: { label: 'Size', kind: 'length', help: 'Extent along X, Y and Z.' },
  pieces: { label: 'Pieces', kind: 'count', help: 'Connected pieces of the surface.' },
  critical_slope_deg: { label: 'Critical slope', kind: 'angle', help: 'Slope below which the toroidal cutter is faster than the ball-end cutter, by the published method.' },
  uncut_mm: { label: 'Uncut', kind: 'height', help: 'Height of the material that the cutter cannot reach.' },
};

const PROGRAM_TERMS = {
  program_decimals: { label: 'Decimals', kind: 'count', help: 'Decimals of the coordinates.' },
  program_tool: { label: 'Tool number', kind: 'count', help: 'T word of the tool call.' },
  ...Object.fromEntries(['program_origin', 'origin'].flatMap((name) => ['x', 'y', 'z'].map((axis) => [`${name}_${axis}_mm`, { label: `Zero point ${axis.toUpperCase()}`, kind: 'length', help: 'Where the program’s zero point is in the coordinates of the part, such as a corner of the stock.' }]))),
  program_spindle_speed_rpm: { label: 'S word', kind: 'speed', help: 'Spindle speed of the program. Empty: the cutter’s, at most the machine’s.' },
  program_header: { label: 'Header blocks', help: 'Blocks at the beginning of the program, one a line.' },
  program_footer: { label: 'Footer blocks', help: 'Blocks before M5 and M30, one a line.' },
};

const SIDE_OF_BOX = 'Only facets whose centroid lies in this box are machined. Drag over the map to choose it.';

// Dimensions that the cutter before has as well.
const OF_CUTTERS = ['diameter_mm', 'corner_radius_mm', 'taper_deg', 'shank_diameter_mm', 'lens_radius_mm', 'tip_radius_mm', 'side_radius_mm', 'arcs'];

// The page’s own names, for nested members and for fields with another name in the service.
const OF_THE_PAGE = {
  ...PROGRAM_TERMS,
  ...Object.fromEntries(OF_CUTTERS.map((name) => [`rest_of_${name}`, { ...NAMES[name], label: `Its ${NAMES[name].label.toLowerCase()}` }])),
  tolerance_of_plan: { label: 'Tolerance', kind: 'height', help: 'Largest scallop height that the plan may leave, tooth marks included.' },
  machine_feed_rate_mm_min: { label: 'Feed rate', kind: 'feedRate', help: 'The feed rate of the machine for finishing.' },
  scallop_p99_mm: { label: 'Scallop p99', kind: 'height', help: 'Scallop height that 99 % of the area that the cutter can reach does not exceed.' },
  scallop_max_mm: { label: 'Scallop max', kind: 'height', help: 'Largest scallop height on the area that the cutter can reach.' },
  links_lifts: { label: 'Lifts', kind: 'count', help: 'Links that lift the tool to the clearance height.' },
  rectangle_time_s: { label: 'By rectangle', kind: 'time', help: 'Time by the published method, which replaces the surface by an inclined rectangle.' },
  contacts: { label: 'Contacts', help: 'Rows of the table that touch the surface.' },
  moves_off: { label: 'Off the surface', help: 'Rows without a normal: links, lifts and rapid moves. Nothing is asked for them.' },
  failures: { label: 'Without an answer', help: 'Rows for which the service has no answer. They are empty in the download.' },
  time_at_feeds_s: { label: 'Time at these feeds', kind: 'time', help: 'Distance between the positions of each run over the feed rate, without acceleration and links. Where rows have no feed, the share of the path that is timed is stated.' },
  moves: { label: 'Moves', kind: 'count', help: 'Moves of the program, arcs in chords.' },
  cutting_length_mm: { label: 'Cutting length', kind: 'length', help: 'Length of the moves at the feed rate.' },
  rapid_length_mm: { label: 'Rapid length', kind: 'length', help: 'Length of the rapid moves.' },
  idle_length_mm: { label: 'Idle length', kind: 'length', help: 'Length of the moves that cut less than a tenth of the tolerance and could be left out.' },
  residual_p50_mm: { label: 'Left, median', kind: 'height', help: 'Material left over the surface: half of the area has less.' },
  residual_p90_mm: { label: 'Left, p90', kind: 'height', help: 'Material left over the surface that 90 % of the area do not exceed.' },
  residual_p99_mm: { label: 'Left, p99', kind: 'height', help: 'Material left over the surface that 99 % of the area do not exceed.' },
  residual_max_mm: { label: 'Left, most', kind: 'height', help: 'The most material that was found left over the surface.' },
  scallop_with_marks_mm: { label: 'Scallop with marks', kind: 'height', help: 'Scallop height with the tooth marks of the program’s feeds.' },
  never_kept_share: { label: 'Never kept', kind: 'share', help: 'Share of the area that is over the tolerance at any feed.' },
  time_with_new_feeds_s: { label: 'Time, new feeds', kind: 'time', help: 'Machining time with the largest feeds that keep the tolerance.' },
  height_over_datum: { label: 'Height', kind: 'length', help: 'Z of the surface.' },
  select_slope_from_deg: { label: 'Slope from', kind: 'angle', help: 'Only facets at least as steep are machined.' },
  select_slope_to_deg: { label: 'Slope to', kind: 'angle', help: 'Only facets at most as steep are machined.' },
  pieces_selected: { label: 'Pieces', help: 'Numbers of the connected pieces to machine, from 0 in the order of their first facets, separated by commas. Empty: all.' },
  ...Object.fromEntries(['x', 'y', 'z'].flatMap((axis) => [['min', 'from'], ['max', 'to']].map(([end, word]) => [`box_${end}_${axis}_mm`, { label: `${axis.toUpperCase()} ${word}`, kind: 'length', help: SIDE_OF_BOX }]))),
};

export const TERMS = { ...NAMES, ...OF_THE_PAGE };

/** The types of cutters with their labels, for the choices of forms. */
export const CUTTER_TYPES = [['toroidal', 'Bull nose'], ['ball_end', 'Ball end'], ['flat_end', 'Flat end'], ['tapered_ball', 'Tapered ball'], ['lens', 'Lens'], ['oval', 'Oval'], ['conical_barrel', 'Conical barrel'], ['profile', 'Profile']];

// The page’s texts for words of the service.
const WORDS = {
  ...Object.fromEntries(CUTTER_TYPES),
  scallop_tolerance: 'the tolerance',
  max_feed_per_tooth: 'the cutter’s feed limit',
  max_feed_rate: 'the machine’s feed limit',
  min_step_over: 'the smallest step-over',
  max_step_over: 'the largest step-over',
};

export const inWords = (word) => WORDS[word] ?? String(word).replaceAll(/[-_]/g, ' ');

/** The label of a cutter of an answer: its name, or its shape and number. */
export const nameOf = (candidate) => candidate.name ?? `${inWords(candidate.type ?? 'cutter')} ${candidate.cutter + 1}`;
