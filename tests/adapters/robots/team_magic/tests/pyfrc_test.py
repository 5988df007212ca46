from pyfrc.tests import *  # noqa: F403
