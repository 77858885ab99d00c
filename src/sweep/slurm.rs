//! A sweep as a Slurm job array.

use std::path::Path;

use super::Plan;

/// The script: given to `sbatch` it is the array; run by a shell it submits itself, and the merge after it.
///
/// `tasks` is the longest array (Slurm's own limit, `MaxArraySize`, is 1001 unless the site changed it), `at_once` how many
/// of them may run at a time.
#[must_use]
pub fn script(
    plan: &Plan,
    program: &Path,
    sweep: &Path,
    output: &Path,
    tasks: usize,
    at_once: Option<usize>,
) -> String {
    let points = plan.points.len();
    let per_task = points.div_ceil(tasks.max(1)).max(1);
    let last = points.div_ceil(per_task) - 1;
    let throttle = at_once.map_or_else(String::new, |at_once| format!("%{at_once}"));
    let name: String =
        plan.name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' }).collect();
    let [program, sweep, output] = [program, sweep, output].map(|path| quoted(&path.display().to_string()));
    format!(
        r#"#!/bin/sh
#SBATCH --job-name=texunit-{name}
#SBATCH --array=0-{last}{throttle}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --output=/dev/null
# {points} points, {per_task} a task. `sbatch THIS` runs them; `sh THIS` runs them and then merges.
set -eu
texunit={program}
sweep={sweep}
output={output}
if [ -z "${{SLURM_ARRAY_TASK_ID:-}}" ]; then
    array=$(sbatch --parsable "$0")
    echo "array job $array"
    sbatch --dependency="afterok:$array" --job-name=texunit-{name}-merge --output=/dev/null \
        --wrap "'$texunit' sweep merge '$sweep' -o '$output'"
    exit
fi
mkdir -p "$output"
first=$((SLURM_ARRAY_TASK_ID * {per_task}))
last=$((first + {per_task} - 1))
exec "$texunit" sweep point "$sweep" "$first-$last" -o "$output" --jobs 1 2> "$output/task-$SLURM_ARRAY_TASK_ID.log"
"#
    )
}

/// For a shell, as one word.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}
