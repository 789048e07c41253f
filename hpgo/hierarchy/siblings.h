// The lists of children: of the nodes of a group, of the edges under a coarse edge.
#pragma once

#include "hpgo/hierarchy/level.h"

namespace hpgo {

// Puts items[k] at the head of the list that begins at `first`.
template <typename Items>
void LinkSibling(Index k, Index* first, Items* items) {
  auto& item = (*items)[k];
  item.next_sibling = *first;
  item.prev_sibling = kNone;
  if (*first != kNone) (*items)[*first].prev_sibling = k;
  *first = k;
}

// Takes items[k] out of it.
template <typename Items>
void UnlinkSibling(Index k, Index* first, Items* items) {
  auto& item = (*items)[k];
  if (item.prev_sibling == kNone) {
    *first = item.next_sibling;
  } else {
    (*items)[item.prev_sibling].next_sibling = item.next_sibling;
  }
  if (item.next_sibling != kNone) (*items)[item.next_sibling].prev_sibling = item.prev_sibling;
  item.next_sibling = item.prev_sibling = kNone;
}

}  // namespace hpgo
