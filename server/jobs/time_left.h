#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace anyrate {

/// Estimates how long a job will still take: what it took so far, by the parts of a job that its stages usually take.
class TimeLeft {
public:
    /// @param growth  vertices that the refinement adds
    explicit TimeLeft(int growth);

    /// The job stands here. @param fraction  of the stage, 0..1 @param seconds  since this worker began
    void reach(std::string_view stage, double fraction, double seconds);
    /// nullopt while there is too little to go by.
    std::optional<double> seconds() const;

private:
    double growth_;
    std::string stage_;
    double fraction_ = 0;                          ///< of the stage
    double stage_begun_ = 0, stage_begun_at_ = 0;  ///< seconds, and the fraction of it then
    double done_ = 0;                              ///< work, in parts of a usual job
    double leapt_ = 0;                             ///< of it, what an earlier worker has done
    double elapsed_ = 0;                           ///< seconds
};

}  // namespace anyrate
