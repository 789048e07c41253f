// Flags that several subcommands share. Each is defined once, here, with its one default; a command
// lists the ones it takes in Command::flags. --quiet, --v and --help belong to every command.
#pragma once

#include <string>

#include "ceres_costs/relative_pose_error.h"
#include "gflags/gflags.h"

DECLARE_bool(quiet);
DECLARE_string(output);
DECLARE_string(stats_json);
DECLARE_string(json);
DECLARE_string(title);
DECLARE_uint64(seed);

// Whether the flag of this name, of any command, names a file to write.
bool IsOutputFlag(const std::string& name);

// Reading.
DECLARE_bool(strict);
DECLARE_bool(project_information);
DECLARE_bool(identity_information);
DECLARE_bool(create_missing);
DECLARE_bool(row_major_edge2);

// What is minimized.
DECLARE_string(error);
DECLARE_string(loss);
DECLARE_double(loss_scale);
DECLARE_string(loss_on);

// How.
DECLARE_string(init);
DECLARE_string(engine);
DECLARE_int32(max_iterations);
DECLARE_double(max_seconds);

// What --error says, checked by the command.
ceres_costs::ErrorConvention ConventionOfFlag();

// The degrees of freedom of a pose (upright_file.h).
DECLARE_int32(dof);

// The hierarchy; 0: the default.
DECLARE_int32(max_top_nodes);
DECLARE_int32(max_top_edges);

// What poses are compared with; seeing 3D poses in 2D (pose_source.h).
DECLARE_string(reference);
DECLARE_string(plane);
DECLARE_bool(by_order);
