#!/bin/sh
# Scores what the agent left behind. It installs eai only where the agent's box is the verifier's, too.
set -e
cd /tests
python -c 'import eai.extensions.harbor' 2>/dev/null || python -m pip install --quiet --disable-pip-version-check $requirements
mkdir -p /logs/verifier
python -m eai.extensions.harbor.verify "$$EAI_TASK" > /logs/verifier/reward.json.part
mv /logs/verifier/reward.json.part /logs/verifier/reward.json
