// Options, limits and reports of the Optimizer.
#pragma once

#include "hpgo/update/options.h"
#include "hpgo/update/report.h"
