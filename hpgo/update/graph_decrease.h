// What a step on a level above level 0 does to the cost of the graph itself.
#pragma once

#include <vector>

#include "hpgo/solve/window.h"

namespace hpgo {

// What a coarse edge may miss of the pull of those below when its ends move and it changes by so
// much, both in sqrt(chi2): their errors turn with it, those they have and those that the step
// brings.
template <typename G>
double MissedPull(const LevelEdge& edge, const G& before, const G& after, double change);

// Whether coarse edges are taken at their word where they can miss but little.
enum class Asking { kWhereInDoubt, kAll };

// By how much it falls, in chi2, when the window's poses go to where its step says, which promises
// so much and changes each edge of the window by so much. Coarse edges speak for those below, and
// may miss some. Where that is more than kShareMissedUnasked of the promise, those of level 0 are
// asked that may miss much, and all where these miss more than they might; kMostAskedBelow are
// looked at. Or all in any case, those first that may miss most, and kMostOfAllAsked.
template <typename G>
double GraphDecrease(const Window<G>& window, double promised, const std::vector<double>& changes,
                     const Hierarchy<G>& hierarchy, Asking asking = Asking::kWhereInDoubt);

}  // namespace hpgo
