// Levels as ceres::Problems: what Optimizer::LevelProblem and ProblemSolver::LevelProblem give.
#pragma once

#include "hpgo/solve/level_problem.h"
