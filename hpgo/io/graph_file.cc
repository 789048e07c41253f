#include "hpgo/io/graph_file.h"

namespace hpgo {

template <typename G>
void GraphFile<G>::AddRecord(RecordKind kind, int index) {
  if (!order.empty()) {
    RecordRun& last = order.back();
    if (last.kind == kind && last.first + last.count == index) {
      ++last.count;
      return;
    }
  }
  order.push_back({kind, index, 1});
}

template struct GraphFile<SE2>;
template struct GraphFile<SE3>;

}  // namespace hpgo
