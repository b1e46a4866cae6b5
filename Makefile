# Everything here needs only make and Python 3.11 or newer; the first target that runs creates the virtual environment.
PYTHON ?= python3
VENV ?= .venv
JOBS ?= 2
EPISODES ?= 100
PANDA_PUSH_EPISODES ?= 50
OUT ?= runs
LEROBOT_VENV ?= .venv-lerobot
OLDEST_VENV ?= .venv-oldest
STUDENT ?= baselines/checkpoints/diffusion_pusht_keypoints

INSTALLED := $(VENV)/.installed
LEROBOT_INSTALLED := $(LEROBOT_VENV)/.installed
OLDEST_INSTALLED := $(OLDEST_VENV)/.installed
# The policies are small: more threads than one only wait for each other.
RUN := OMP_NUM_THREADS=1 $(VENV)/bin/python
LEROBOT_RUN := OMP_NUM_THREADS=1 $(LEROBOT_VENV)/bin/python
AICON := $(VENV)/bin/aicon
LEROBOT_AICON := $(LEROBOT_VENV)/bin/aicon

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help install lerobot-env test test-all test-oldest test-lerobot compare panda_push reach figures benchmark lint docs format clean

help: ## Show this list
	@echo "make TARGET, where TARGET is one of"
	@sed -nE 's/^([a-z_-]+):.*## (.*)/  \1|\2/p' $(firstword $(MAKEFILE_LIST)) | awk -F '|' '{ printf "%-12s %s\n", $$1, $$2 }'
	@echo "Settings: PYTHON=$(PYTHON) VENV=$(VENV) LEROBOT_VENV=$(LEROBOT_VENV) JOBS=$(JOBS) EPISODES=$(EPISODES) PANDA_PUSH_EPISODES=$(PANDA_PUSH_EPISODES) OUT=$(OUT)"

install: $(INSTALLED) ## Create the virtual environment (the other targets do it if need be)

$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "aicon-torch needs Python 3.11 or newer, and $(PYTHON) is older or missing."; \
	  echo "Name another one: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)"; exit 1; } >&2
	$(PYTHON) -m venv --clear $(VENV)
	$(VENV)/bin/python -m pip install --disable-pip-version-check -c constraints.txt -e ".[all]"
	@touch $@

lerobot-env: $(LEROBOT_INSTALLED) ## Create the virtual environment with LeRobot (8 GB, needs a C compiler)

$(LEROBOT_INSTALLED): pyproject.toml constraints-lerobot.txt baselines/lerobot_policy_aicon/pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 12))' 2>/dev/null || { \
	  echo "constraints-lerobot.txt is for Python 3.11, and $(PYTHON) is another one or missing."; \
	  echo "Name one: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS); or install without it: pip install -e '.[lerobot]'"; \
	  exit 1; } >&2
	$(PYTHON) -m venv --clear $(LEROBOT_VENV)
	$(LEROBOT_VENV)/bin/python -m pip install --disable-pip-version-check -c constraints-lerobot.txt \
	  -e ".[lerobot,compare,pusht,upstream]" -e baselines/lerobot_policy_aicon hypothesis pytest pytest-xdist
	@touch $@

# Without OpenGL the tests of the arm that render are skipped.
test: $(INSTALLED) ## Run the tests, but for the slow ones
	$(RUN) -m pytest -n $(JOBS)

test-all: $(INSTALLED) ## Run all tests
	$(RUN) -m pytest -n $(JOBS) -m ""

$(OLDEST_INSTALLED): pyproject.toml
	$(PYTHON) -m venv --clear $(OLDEST_VENV)
	$(OLDEST_VENV)/bin/python -m pip install --disable-pip-version-check uv
	$(OLDEST_VENV)/bin/uv pip install --python $(OLDEST_VENV)/bin/python --resolution lowest-direct -e ".[all]"
	@touch $@

# Warnings are no errors here: most are those of old packages about new ones.
test-oldest: $(OLDEST_INSTALLED) ## Run the tests with the oldest versions that pyproject.toml allows
	OMP_NUM_THREADS=1 $(OLDEST_VENV)/bin/python -m pytest -W default -n $(JOBS)

# Warnings are no errors here: most are those of LeRobot about its own dependencies.
test-lerobot: $(LEROBOT_INSTALLED) ## Run the tests that need LeRobot
	$(LEROBOT_RUN) -m pytest -W default -n $(JOBS) tests/baselines/agents/diffusion tests/baselines/agents/lerobot

compare: $(INSTALLED) ## Compare AICON with its baselines in 2D navigation and pushT: tables, curves and pictures
	$(AICON) compare --task nav2d --policies aicon paper_literal steepest potential_field \
	  --episodes $(EPISODES) --seed 0 --jobs $(JOBS) --out $(OUT)/nav2d
	$(AICON) compare --task pusht --policies aicon paper_literal steepest potential_field \
	  --conditions deterministic noise_2 --episodes $(EPISODES) --seed 200 --jobs $(JOBS) --out $(OUT)/pusht
	@if [ -e $(LEROBOT_INSTALLED) ]; then $(LEROBOT_AICON) compare --task pusht --policies diffusion \
	  --diffusion-path $(STUDENT) --conditions deterministic noise_2 --episodes $(EPISODES) --seed 200 --jobs $(JOBS) \
	  --out $(OUT)/pusht; else echo "Without the diffusion policy, which needs LeRobot: make lerobot-env"; fi
	@$(MAKE) --no-print-directory figures
	@echo "The numbers of the tables: summary.json; one row per episode: episodes.csv; the pictures:"
	@ls $(OUT)/*/*.png $(OUT)/*/*.gif $(OUT)/*/*.mp4 2>/dev/null | sed 's/^/  /'

panda_push: $(INSTALLED) ## Compare the arm's policies and draw its film; rendering needs system packages
	@$(RUN) -c 'import aicon_envs.panda_push as p; p.PandaPushEnv().reset(seed=0)' || { \
	  echo "The arm cannot be rendered here. On Debian: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri"; exit 1; } >&2
	$(AICON) compare --task panda_push --policies aicon steepest --conditions camera true_pose \
	  --episodes $(PANDA_PUSH_EPISODES) --seed 0 --jobs $(JOBS) --out $(OUT)/panda_push
	$(AICON) figures panda_push --out $(OUT)/panda_push

# Every robot with the same numbers; 20 s an episode.
REACH_CONDITIONS := $(foreach robot,panda ur5 xarm7,$(addprefix $(robot)_,position_home position_random \
  pose_home pose_random pose_home_fast pose_random_fast))

reach: $(INSTALLED) ## Compare arms that reach with inverse kinematics, the sum and the steepest path
	$(AICON) compare --task reach --policies aicon steepest potential_field damped_least_squares mink \
	  --conditions $(REACH_CONDITIONS) --episodes $(EPISODES) --seed 0 --jobs $(JOBS) --out $(OUT)/reach
	$(AICON) figures reach --out $(OUT)/reach

docs: $(INSTALLED) ## Build the site of these documents in docs/_build; warnings are errors
	$(RUN) -m sphinx -W --keep-going -q -b html docs docs/_build
	@echo "The site: docs/_build/index.html"

figures: $(INSTALLED) ## Draw the figure and the film of a rollout in each task of the plane
	$(AICON) figures nav2d --out $(OUT)/nav2d
	$(AICON) figures pusht --out $(OUT)/pusht

benchmark: $(INSTALLED) ## Measure the time of a control step
	$(RUN) scripts/benchmark.py

lint: $(INSTALLED) ## Check style and types
	$(RUN) -m ruff check
	$(RUN) -m ruff format --check
	$(RUN) -m mypy

format: $(INSTALLED) ## Put the code into the project's format
	$(RUN) -m ruff check --fix
	$(RUN) -m ruff format

clean: ## Remove the virtual environments and what tools left behind, but no results
	rm -rf .venv .venv-lerobot .venv-oldest build dist .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find aicon_torch envs baselines scripts tests -name __pycache__ -type d -prune -exec rm -rf {} +
