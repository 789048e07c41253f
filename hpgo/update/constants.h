// The numbers that steer an update, but for the caller's (options.h). Each names the quantity that
// it bounds; README.md says which of them a test holds.
#pragma once

#include <cstdint>

namespace hpgo {

// --- What is worth looking at.
// The mean chi2 follows the estimate by samples: so many edges an update and one more for each new
// edge, over the last kMeanMemory of them.
inline constexpr int kSamplesPerUpdate = 4, kMostSamplesPerUpdate = 1000, kMeanMemory = 2000;
// Means by which a sample counts at most: an edge that does not fit yet says nothing of the noise.
inline constexpr double kMostMeansOfASample = 10;
// What a chain's model may miss before it is linearized anew, of what makes a merge worth it.
inline constexpr double kChainToleranceOfDirty = 0.2;
// Edges of a node, on each level, that a removal makes the search look at.
inline constexpr int kMostDisturbedEdges = 64;

// --- A solve of a window.
// Taus by which a step misses what its linearization promised for another one to be worth it.
inline constexpr double kTausMissedForAnother = 10;
// How much too stiff a model is taken to be at most, by what its step gained.
inline constexpr double kMostTooStiff = 100;
// Of a usual window, what a solve of the smallest one costs.
inline constexpr double kLeastWorthOfASolve = 0.05;
// Edges in chains that are linearized, or asked what they cost, in the time of a usual window.
inline constexpr double kVisitedOfAWindow = 1000;
// Edges in chains up to which a window is solved again: by the size of their matrices, so that they
// take a few times as long as a slow update does.
template <typename G>
inline constexpr double kMostVisited = 2.5e6 / (G::kDof * G::kDof * G::kDof);
// Times that a step whose chains cost more where it ends is made shorter, and by which factor.
inline constexpr int kShorterSteps = 3;
inline constexpr double kShorterStep = 0.3;
// Of what a step above level 0 promises, what its edges may miss before those below are asked
// whether the cost falls; and how many of them are asked at most, and where all are to be.
inline constexpr double kShareMissedUnasked = 0.01;
inline constexpr int kMostAskedBelow = 2000, kMostOfAllAsked = 10000;

// --- Windows by time.
// Of a limit, for one window.
inline constexpr double kWindowShareOfTime = 0.35;
// The time of a window grows with this power of its size: the factorization fills in.
inline constexpr double kFillGrowth = 1.3;
// Sizes of the options to which windows may grow where time bounds them or nothing does, and how
// fast: one that needed damping is followed by small ones.
inline constexpr double kLargestWindow = 20, kWindowGrowth = 1.5;
// Sizes of the options below which the time of a window says little.
inline constexpr double kSmallestTimedWindow = 0.5;
// By which the expected time goes down, and up: rather too small a window than an update that takes
// too long.
inline constexpr double kShareOfFaster = 0.2, kShareOfSlower = 0.5;
// Edges merged between two looks at the clock.
inline constexpr int kMergesPerLookAtClock = 64;

// --- The whole graph.
// Edges of the graph for each new one up to which an update solves it with its chains opened where
// what is new is far off: no more than updates one by one would cost.
inline constexpr double kOpenedPerNew = 10;
inline constexpr int kFullIterations = 200;
// Chains are linearized in turns with the solve of what is between them; the last gains less than
// this share of the cost.
inline constexpr int kFullTurns = 50;
inline constexpr double kFullStandstill = 1e-10;
// Iterations that a whole solve needs for Converge to choose it: fewer leave a gap.
inline constexpr int kIterationsToFit = 3;

// --- Far from the optimum.
// An update that gains more than this share of the cost is, or than the root of what its solves are
// of level 0 says of it; and a step on level 0 that misses as much is followed by another one,
// though the budget is spent.
inline constexpr double kShareOfFarOff = 0.01;

// --- Closures that are far off, where most edges are in chains: a degree of their way.
// rad; and, of the distance to the farthest of a window's nodes around an end, m.
inline constexpr double kTurnOfADegree = 0.3, kExtentOfADegree = 0.1;
// Where all of those are in one place.
inline constexpr int kMostDegrees = 50;
// Of a degree, what is left to where an edge pulls when it has all but come there.
inline constexpr double kNearly = 0.5;
// Windows that edges under way wait for one that does not come there.
inline constexpr int kMostWindowsOfADegree = 20;
// Times that an update solves its windows meanwhile.
inline constexpr int kRoundsOfAnUpdate = 4;

// --- Newton steps in slices.
// So many updates in a row that are far from the optimum are not just a closure, or two.
inline constexpr int kUpdatesFarOff = 4;
// Numbers multiplied by an update: 16 ms. Four times as many updates, each of a quarter of that,
// take longer in all, since windows go on beside them.
inline constexpr double kMultiplicationsOfASlice = 2.4e8;
// Of level 0: it is ordered, linearized and moved in one update each. 0.1 to 0.2 s at
// 23,000.
inline constexpr int kMostNodesOfNewton = 30000;
// Of the factor: 240 MB. Dense worlds of 15,000 have a third of it.
inline constexpr std::int64_t kMostNumbersOfNewton = 30'000'000;

// --- Refine.
// Everything is examined again at thresholds this many times smaller, each kDeeper times the last;
// on ill-conditioned graphs further than kDeep while a round gains kGainToGoDeeper of the cost.
inline constexpr double kDeep = 100, kDeeper = 10, kGainToGoDeeper = 1e-5;
// Where the levels' models disagree, windows may undo each other's work for ever: after so many
// passes over the graph it is solved whole.
inline constexpr double kMostPasses = 20;

}  // namespace hpgo
