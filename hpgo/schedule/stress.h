// Where work is worth doing: the stress of nodes, and the search for it along pending edges.
#pragma once

#include <vector>

#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

// The thresholds of one update, from the mean chi2 per edge.
struct StressThresholds {
  double tau = 0;     // a window opens where the predicted decrease of chi2 exceeds it
  float pending = 0;  // in sqrt(chi2): smaller changes are not worth a look
  float dirty = 0;    // in sqrt(chi2): nor a merge
  // tau = relative * mean, the others sqrt(tau) / 2.
  static StressThresholds FromMean(double mean_chi2, double relative);
  // For a step of all of level 0. It moves the members of a group far, and rigidly where a loop
  // closes, while the group's frame stays: what pulls at it from elsewhere then has hardly changed,
  // adds up, and windows above would undo the step by it. So what is above any change is dirty.
  StressThresholds MergingAll(CoarseEdges coarse_edges) const;
};

// The predicted decrease of chi2 when one node moves alone, g' H^-1 g; 0 for a constant node. Looks
// at no more than `max_edges` of its edges, and adds how many to `looked_at` unless null.
template <typename G>
double NodeStress(int l, Index node, int max_edges, Hierarchy<G>* hierarchy,
                  int* looked_at = nullptr);

// Adds to an edge's pending.
template <typename G>
void AddPending(int l, Index edge, double amount, const StressThresholds& thresholds,
                Hierarchy<G>* hierarchy);

// Hands `amount` down to the children of a coarse edge, in equal shares of its square.
template <typename G>
void HandDown(int l, Index edge, double amount, const StressThresholds& thresholds,
              Hierarchy<G>* hierarchy);

// Notes that what a coarse edge stands for is no longer what it says, by `amount`; queues it for
// merging when it adds up.
template <typename G>
void NoteChanged(int l, Index edge, double amount, const StressThresholds& thresholds,
                 Hierarchy<G>* hierarchy);

// The same of the parent of an edge that has changed.
template <typename G>
void TellParent(int l, Index edge, double amount, const StressThresholds& thresholds,
                Hierarchy<G>* hierarchy);

struct FoundWork {
  bool found = false;
  Index ends[2] = {kNone, kNone};  // where the window starts
  int examined = 0;                // edges: pending ones, and those of their ends
};

// Examines the most pending edges of a level: each hands its pending down and is done with, until
// one has an end under more stress than tau. Begins with no further one after `max_edges` edges, of
// a single node at most `max_degree`.
template <typename G>
FoundWork FindWork(int l, int max_edges, int max_degree, const StressThresholds& thresholds,
                   Hierarchy<G>* hierarchy);

// The largest pending of a level, 0 if none is worth a look.
template <typename G>
double LargestPending(int l, const Hierarchy<G>& hierarchy);

}  // namespace hpgo
