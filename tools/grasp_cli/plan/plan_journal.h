/// What a plan has found so far, on disk, so that a run that was stopped can be gone on with.
#pragma once

#include "grasp/formats/grasp_recorder.h"

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// grasps.journal.jsonl in the output folder: the records of all candidates, rejected ones too, in
/// the order in which they were finished, each with one write; so a process that is killed loses
/// the candidates alone that it was working on. One run at a time writes into it.
class PlanJournal
{
public:
    /// Takes over the journal of a stopped run, or renames it to *.old and begins an empty one. A
    /// last line that was not finished is cut off.
    /// Keeps references: all three must outlive it.
    /// Throws std::runtime_error "<file>: <what>: <remedy>", also if the journal is in use, or to
    /// be taken over and of another hand, object, version or other options.
    PlanJournal(const std::filesystem::path& folder,
                const grasp::GraspRun& run,
                const grasp::HandModel& hand,
                const grasp::GraspObject& object,
                bool resume);
    /// A journal without records goes.
    ~PlanJournal();
    PlanJournal(const PlanJournal&) = delete;
    PlanJournal& operator=(const PlanJournal&) = delete;

    /// Of the stopped run, in the order of the file.
    [[nodiscard]] const std::vector<grasp::Grasp>& known() const { return m_known; }
    /// Where the journal of a stopped run is now that was not taken over; empty if there was none.
    [[nodiscard]] const std::filesystem::path& setAside() const { return m_setAside; }
    [[nodiscard]] const std::filesystem::path& file() const { return m_file; }

    /// Thread-safe. Throws std::runtime_error if the disk is full.
    void append(const grasp::Grasp& grasp);
    /// All is done: the journal is not needed any more.
    void remove();

private:
    void open();
    void close();
    void takeOver(const grasp::GraspRun& run,
                  const grasp::HandModel& hand,
                  const grasp::GraspObject& object);
    [[noreturn]] void fail(const std::string& what) const;

    std::filesystem::path m_file;
    std::filesystem::path m_setAside;
    grasp::GraspRecorder m_recorder;
    std::vector<grasp::Grasp> m_known;
    std::mutex m_mutex;
    int m_descriptor = -1;
};
}  // namespace bullet_ccd::tools
