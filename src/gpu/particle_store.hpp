#pragma once
// The memory of a device's particles: their rows, which of their slots are in use, and when rows are next put into list
// order (memory/refresh.hpp).

#include "core/transfer/method.hpp"
#include "gpu/exchange/particle_record.hpp"
#include "gpu/memory/particles.hpp"
#include "gpu/memory/refresh_clock.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct ParticleStore {
    ParticleStore(const ColumnNeeds& needs, int refresh_interval, std::size_t cache_bytes)
        : rows(needs), clock(refresh_interval), cache(cache_bytes) {}

    DeviceParticles<Real, Dim> rows;
    Array<Real> gradient;  ///< dL by list entry, where the stress has kernels of its own
    RefreshClock clock;
    const std::size_t cache;  ///< of the device [bytes]
    std::size_t used = 0;     ///< slots in use when the last report was made

    RecordLayout records() const { return record_layout(rows.view(), rows.rest()); }
    /// For an epoch that begins with so many particles.
    void open(std::int64_t particles) { clock.fit(static_cast<std::size_t>(particles) * records().bytes(), cache); }
};

}  // namespace moraine::gpu
