// The lines of a coordinator's log about its farm.
#pragma once

#include "service/farm/farm_news.h"

namespace tessera::server {

/// Thread-safe.
class FarmLog final : public FarmObserver {
 public:
  void note(const FarmNews& news) override;
};

}  // namespace tessera::server
